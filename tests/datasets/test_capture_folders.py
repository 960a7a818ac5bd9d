"""One folder that cannot be used never keeps the others from being used, and is told of."""

import os
from pathlib import Path

import pytest

from avs.datasets import capture_folders
from avs.datasets.capture_folders import capture_files, find_captures
from avs.system.errors import UserError


def capture(folder, *images):
    """The folders of a capture, with empty files."""
    for path in ("sparse/0/cameras.bin", *(f"images/{name}" for name in images or ["a.png"])):
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).touch()


def told(folder):
    """The scene names, and the causes for which others are left out, by folder."""
    found = find_captures(folder)
    return list(found.folders), {name: reason.cause for name, reason in found.left_out.items()}


def test_a_capture_may_be_a_link_and_has_the_name_of_the_link(tmp_path):
    capture(tmp_path / "elsewhere" / "photos")
    (tmp_path / "captures").mkdir()
    (tmp_path / "captures" / "Garden").symlink_to(tmp_path / "elsewhere" / "photos")
    assert told(tmp_path / "captures") == (["garden"], {})
    assert told(tmp_path / "captures" / "Garden") == (["garden"], {})


def test_the_folder_that_is_worked_in_has_a_name(tmp_path, monkeypatch):
    capture(tmp_path / "Garden")
    monkeypatch.chdir(tmp_path / "Garden")
    assert find_captures(Path()).folders == {"garden": Path()}


def test_a_second_name_of_a_capture_is_left_out(tmp_path):
    capture(tmp_path / "fox")
    (tmp_path / "a fox").symlink_to("fox")
    assert told(tmp_path) == (["fox"], {"a fox": "is the same folder as fox"})


def test_a_second_capture_of_a_scene_name_is_left_out(tmp_path):
    for name in ("a_B", "a b", "c", "C"):
        capture(tmp_path / name)
    causes = {"a_B": "has the same scene name, a_b, as a b", "C": "has the same scene name, c, as c"}
    assert told(tmp_path) == (["a_b", "c"], causes)


def test_a_copy_of_a_capture_is_left_out_whatever_its_images_are_called(tmp_path):
    for name, images in {"fox": ("a.png", "b.png"), "fox again": ("1.png", "2.png"), "hen": ("a.png", "b.png")}.items():
        capture(tmp_path / name, *images)
        for content, image in enumerate(images):
            (tmp_path / name / "images" / image).write_bytes(b"ab"[content : content + 1] * (3 + content))
    (tmp_path / "hen" / "images" / "a.png").write_bytes(b"hen")  # of as many bytes
    assert told(tmp_path) == (["fox", "hen"], {"fox again": "has the same photographs as fox"})


@pytest.mark.parametrize("stray", ["Thumbs.db", ".DS_Store", "._a.png"])
def test_what_a_system_leaves_beside_photographs_makes_no_other_scene_of_a_copy(stray, tmp_path):
    for name in ("fox", "fox again"):
        capture(tmp_path / name, "a.png", "b.png")
        for image in ("a.png", "b.png"):
            (tmp_path / name / "images" / image).write_bytes(image.encode())
    (tmp_path / "fox again" / "images" / stray).write_bytes(b"abc")
    assert told(tmp_path) == (["fox"], {"fox again": "has the same photographs as fox"})


@pytest.mark.parametrize("name", [b"\xe9t\xe9.png", b"{scene}.png", b"<scene>.png", b"a\nb.png", b"a.png "])
def test_a_capture_with_a_file_that_the_workflow_cannot_name_is_left_out(name, tmp_path):
    capture(tmp_path / "good")
    capture(tmp_path / "bad", os.fsdecode(name))
    names, causes = told(tmp_path)
    assert names == ["good"]
    assert causes["bad"].startswith("has a file whose name the workflow cannot take, images/")
    assert "\n" not in causes["bad"]
    causes["bad"].encode()


def test_such_a_file_beside_what_is_read_does_not_matter(tmp_path):
    capture(tmp_path / "good")
    (tmp_path / "good" / "{notes}.txt").touch()
    (tmp_path / "good" / "dense").mkdir()
    (tmp_path / "good" / "dense" / os.fsdecode(b"\xe9")).touch()
    assert told(tmp_path) == (["good"], {})


@pytest.mark.parametrize("name", [b"\xe9t\xe9", b"{scene}", b"<scene>"])
def test_a_capture_whose_own_name_the_workflow_cannot_take_is_left_out(name, tmp_path):
    capture(tmp_path / "good")
    capture(tmp_path / os.fsdecode(name))
    names, causes = told(tmp_path)
    assert names == ["good"]
    assert len(causes) == 1


@pytest.mark.parametrize("name", ["\u5199" * 20, "abc" * 30, "a" * 101])
def test_a_capture_whose_scene_name_the_workflow_cannot_take_is_left_out(name, tmp_path):
    """Snakemake takes what ends in 20 repetitions for endless recursion, and files have names of 255 bytes."""
    capture(tmp_path / "good")
    capture(tmp_path / name)
    names, causes = told(tmp_path)
    assert names == ["good"]
    assert causes[name] == "has a scene name of more than 100 characters, or one that ends in 20 repetitions"


def test_an_unreadable_folder_is_left_out(tmp_path, monkeypatch):
    """As lost+found is. The user root may read all, so that the refusal is made here."""
    capture(tmp_path / "good")
    (tmp_path / "lost+found").mkdir()
    iterdir = Path.iterdir

    def refusing(path):
        if path.name == "lost+found":
            raise PermissionError(13, "Permission denied", str(path))
        return iterdir(path)

    monkeypatch.setattr(capture_folders.Path, "iterdir", refusing)
    assert told(tmp_path) == (["good"], {"lost+found": "cannot be read (permission denied)"})


def test_a_link_that_leads_nowhere_is_left_out(tmp_path):
    capture(tmp_path / "good")
    (tmp_path / "moved").symlink_to("gone")
    (tmp_path / "round").symlink_to("round")
    names, causes = told(tmp_path)
    assert names == ["good"]
    assert causes.keys() == {"moved", "round"}


def test_no_capture_that_can_be_used_is_one_line(tmp_path):
    with pytest.raises(UserError, match="holds no capture; give"):
        find_captures(tmp_path)
    with pytest.raises(UserError, match="no such folder"):
        find_captures(tmp_path / "absent")
    capture(tmp_path / "bad", "{a}")
    line = r"holds no capture that can be used \(bad: has a file whose name the workflow cannot take, .*{a}: .*; mend"
    with pytest.raises(UserError, match=line):
        find_captures(tmp_path)


def test_linked_folders_are_inputs_and_circles_end(tmp_path):
    capture(tmp_path / "elsewhere", "deep/a.png")
    (tmp_path / "fox").mkdir()
    for part in ("images", "sparse"):
        (tmp_path / "fox" / part).symlink_to(tmp_path / "elsewhere" / part)
    (tmp_path / "elsewhere" / "images" / "again").symlink_to(tmp_path / "elsewhere")
    os.mkfifo(tmp_path / "elsewhere" / "images" / "pipe")
    files = [path.relative_to(tmp_path / "fox").as_posix() for path in capture_files(tmp_path / "fox")]
    assert files[-1] == "sparse/0/cameras.bin"
    assert sum(name.endswith("a.png") for name in files) == 1
    assert not any("pipe" in name for name in files)
