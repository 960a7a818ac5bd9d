"""A job whose code is not that of the plan, or was written while it ran, is refused."""

import sys
from types import SimpleNamespace

import pytest

from avs.system import loaded_sources, opened_files
from avs.system.code_inputs import digest
from avs.system.errors import UserError
from avs.system.loaded_sources import check_loaded, write_sources

FAULT = r"errors\.py: changed while the run went on"


@pytest.fixture
def listed(tmp_path):
    write_sources(tmp_path / "code.sha256")
    return tmp_path / "code.sha256"


def test_the_code_of_the_plan_passes(listed, monkeypatch):
    monkeypatch.setattr(loaded_sources, "_STARTED", float("inf"))
    check_loaded(listed)
    assert "  avs/system/errors.py\n" in listed.read_text()


def test_other_code_than_that_of_the_plan_is_refused(listed, monkeypatch):
    monkeypatch.setattr(loaded_sources, "_STARTED", float("inf"))
    lines = listed.read_text().splitlines()
    changed = ["0" * 64 + line[64:] if line.endswith("system/errors.py") else line for line in lines]
    listed.write_text("\n".join(changed))
    with pytest.raises(UserError, match=FAULT):
        check_loaded(listed)


def test_code_that_was_put_back_while_the_job_ran_is_refused(listed, monkeypatch):
    path = loaded_sources.ROOT / "avs/system/errors.py"
    monkeypatch.setattr(loaded_sources, "_loaded", lambda told: [path])
    monkeypatch.setattr(loaded_sources, "_STARTED", path.stat().st_mtime - 1)
    with pytest.raises(UserError, match=FAULT):
        check_loaded(listed)


@pytest.mark.parametrize("way", ["_opened", "module"])
def test_an_installed_method_that_changed_since_the_plan_is_refused(tmp_path, monkeypatch, way):
    path = tmp_path / "turning.py"
    path.write_text("SIGN = 1")
    (tmp_path / "unused.py").touch()
    write_sources(tmp_path / "code.sha256", [str(path), str(tmp_path / "unused.py"), "avs/system/errors.py"])
    monkeypatch.setattr(loaded_sources, "_STARTED", float("inf"))
    if way == "module":
        monkeypatch.setitem(sys.modules, "turning", SimpleNamespace(__file__=str(path)))
    else:
        monkeypatch.setattr(opened_files, "_opened", {str(path)})
    check_loaded(tmp_path / "code.sha256")
    for each in (path, tmp_path / "unused.py"):
        each.write_text("SIGN = -1")
    digest.cache_clear()
    with pytest.raises(UserError, match=r"turning\.py: changed while the run went on"):
        check_loaded(tmp_path / "code.sha256")
