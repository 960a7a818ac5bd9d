"""Files that settings name: found in mappings, lists and folders, by links and from the home of the user."""

from pathlib import Path

import pytest

from avs.system import named_files as module
from avs.system.errors import UserError
from avs.system.named_files import named_files


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a file, a hidden one, and a link to another folder with a file; it is the current one."""
    for name in ("model/a.bin", "model/.DS_Store", "elsewhere/b.bin"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(name)
    (tmp_path / "model" / "linked").symlink_to(tmp_path / "elsewhere")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def found(settings):
    return [str(path) for path in named_files(settings)]


def test_of_a_folder_all_files_count_and_links_are_followed(folder):
    below = [f"{folder}/model/a.bin", f"{folder}/model/linked/b.bin"]
    assert found({"deep": [{"model": str(folder / "model")}]}) == below
    assert found({"model": folder / "model"}) == below


def test_tilde_is_the_home_of_the_user(folder, monkeypatch):
    monkeypatch.setenv("HOME", str(folder))
    assert found({"table": "~/elsewhere/b.bin"}) == [f"{folder}/elsewhere/b.bin"]
    assert found({"table": "~/elsewhere"}) == [f"{folder}/elsewhere/b.bin"]
    assert found({"table": "~nobody-of-this-name/b.bin"}) == []


def test_a_plain_word_is_no_folder_but_may_be_a_file(folder):
    assert found({"kind": "model"}) == []
    (folder / "table").write_text("")
    assert found(["table", "model", 3, None, "x" * 5000, "a\0b"]) == ["table"]
    assert found({"kind": Path("elsewhere")}) == ["elsewhere/b.bin"]


def test_a_name_that_the_workflow_cannot_take_is_one_line(folder):
    braces = folder / "{v2}"
    braces.mkdir()
    (braces / "order.txt").write_text("")
    for named in (braces, braces / "order.txt"):
        with pytest.raises(UserError, match=r"\{v2\}/order.txt: is named in the configuration, .*without braces"):
            found({"model": str(named)})


def test_a_folder_of_too_many_files_is_one_line(folder, monkeypatch):
    monkeypatch.setattr(module, "MOST", 1)
    with pytest.raises(UserError, match=r"model: .*more than 1 files.*; name a file in it"):
        found(str(folder / "model"))
