"""Archives of a data set are fetched and unpacked once."""

import json
import shutil
import zipfile

import pytest

from avs.config.data_set_check import archives_of
from avs.datasets import published_archives
from avs.datasets.published_archives import Archive, fetch_archives
from avs.system.downloads import Downloaded
from avs.system.errors import UserError
from avs.system.files import file_hash


@pytest.fixture
def asked(monkeypatch):
    """Let each address give an archive with a folder of its name, and return the addresses that were asked."""
    found = []

    def download(url, target, progress, size=None, sha256=None):
        found.append(url)
        with zipfile.ZipFile(target, "w") as archive:
            archive.writestr(f"{target.stem}/images/a.jpg", b"picture")
            archive.writestr(f"{target.stem}.txt", b"terms")
        return Downloaded(file_hash(target), target.stat().st_size, True)

    monkeypatch.setattr(published_archives, "download", download)
    return found


def test_archives_are_unpacked_once_and_taken_away(asked, tmp_path):
    archives = [Archive("https://example.invalid/one.zip"), Archive("https://example.invalid/two.zip")]
    marks = fetch_archives(archives, tmp_path / "data", False, print)
    assert [json.loads(mark.read_text())["unpacked"] for mark in marks] == [["one", "one.txt"], ["two", "two.txt"]]
    assert (tmp_path / "data/two/images/a.jpg").read_bytes() == b"picture"
    ours = [f"{name}{ending}" for name in ("one", "two") for ending in ("", ".txt", ".zip.json")]
    assert sorted(path.name for path in (tmp_path / "data").iterdir()) == ours
    fetch_archives(archives, tmp_path / "data", False, print)
    assert len(asked) == 2


@pytest.mark.parametrize("gone", [("one",), ("one.txt",), ("one", "one.txt")])
def test_what_is_gone_is_fetched_again_and_the_rest_left_as_it_is(gone, asked, tmp_path):
    archives = [Archive("https://example.invalid/one.zip")]
    fetch_archives(archives, tmp_path, False, print)
    (tmp_path / "one" / "images" / "a.jpg").write_bytes(b"mine")
    (tmp_path / "one.txt").write_bytes(b"mine")
    for name in gone:
        shutil.rmtree(tmp_path / name) if name == "one" else (tmp_path / name).unlink()
    lines = []
    fetch_archives(archives, tmp_path, False, lines.append)
    assert lines[0] == f"one.zip: was unpacked here before; gone since: {', '.join(gone)}"
    assert len(asked) == 2
    assert (tmp_path / "one/images/a.jpg").read_bytes() == (b"picture" if "one" in gone else b"mine")
    assert (tmp_path / "one.txt").read_bytes() == (b"terms" if "one.txt" in gone else b"mine")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one", "one.txt", "one.zip.json"]


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"unpacked": 3}', "\xff"])
def test_a_mark_without_sense_is_none(text, asked, tmp_path):
    (tmp_path / "one.zip.json").write_text(text, encoding="latin-1")
    fetch_archives([Archive("https://example.invalid/one.zip")], tmp_path, False, print)
    assert json.loads((tmp_path / "one.zip.json").read_text())["unpacked"] == ["one", "one.txt"]


def test_archive_that_is_there_is_not_fetched_again(asked, tmp_path):
    with zipfile.ZipFile(tmp_path / "one.zip", "w") as archive:
        archive.writestr("own/a.jpg", b"picture")
    fetch_archives([Archive("https://example.invalid/one.zip")], tmp_path, True, print)
    assert (tmp_path / "own/a.jpg").is_file()
    assert (tmp_path / "one.zip").is_file()
    assert not asked


def test_data_sets_with_terms_are_left_to_the_reader():
    assert [each.name for each in archives_of("mipnerf360")] == ["360_v2.zip", "360_extra_scenes.zip"]
    for name, told in (("mapfree", "mapfree.yaml names"), ("captures", "yourself"), ("nothing", "is unknown")):
        with pytest.raises(UserError, match=told):
            archives_of(name)
