"""``avs data check``: each scene in a line, missing ones named, and a status that scripts can read."""

import shutil

import pytest
from PIL import Image

from avs.config.data_set_check import archives_of, check_data_set
from avs.system.errors import UserError
from tests.datasets.captures_factory import make_capture


@pytest.fixture
def folder(tmp_path):
    make_capture(tmp_path / "garden")
    make_capture(tmp_path / "room")
    Image.new("RGB", (160, 120), "red").save(tmp_path / "room" / "images" / "image 0.png")
    return tmp_path


def lines_of(name, folder, videos=None):
    lines = []
    try:
        check_data_set(name, folder, videos, lines.append)
    except UserError as error:
        return lines, str(error)
    return lines, None


def test_a_whole_data_set(folder):
    assert lines_of("captures", folder) == (
        [
            "garden: 9 pictures with poses, 160 x 120 pixels in the scene",
            "room: 9 pictures with poses, 160 x 120 pixels in the scene",
            "captures: 2 of 2 scenes are there",
        ],
        None,
    )


def test_what_is_missing_or_damaged_is_named(folder):
    shutil.rmtree(folder / "room" / "images")
    lines, fault = lines_of("captures", folder)
    assert "image 0.png: the image is missing" in lines[1]
    assert lines[2] == "captures: 1 of 2 scenes are there"
    assert fault.endswith("1 scenes are missing or damaged; get them as docs/data.md says, or leave them out by `only`")


def test_the_scenes_of_the_paper_s_configuration_are_wanted(folder):
    Image.new("RGB", (80, 60)).save(folder / "room" / "images" / "image 0.png")
    lines, _ = lines_of("mipnerf360", folder)
    assert sum("is not there" in line for line in lines) == 7
    assert sum("a smaller copy" in line for line in lines) == 1


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("nosuch", "data set nosuch: is unknown; name one of aria_dtc"),
        ("embedded", "data set embedded: is made on the spot from no files of yours; name another one"),
    ],
)
def test_a_name_that_is_no_data_set_in_files_is_refused(name, fault, folder):
    assert lines_of(name, folder)[1].startswith(fault)
    with pytest.raises(UserError) as caught:
        archives_of(name)
    assert str(caught.value).startswith(fault)


@pytest.mark.parametrize("name", ["captures", "mipnerf360", "mapfree"])
def test_videos_of_a_data_set_without_are_refused(name, folder):
    assert lines_of(name, folder, folder) == ([], f"data set {name}: has no videos; leave the option --videos out")


@pytest.mark.parametrize("name", ["realestate10k"])
def test_a_folder_without_texts_is_told_as_such(name, folder):
    assert "holds no texts <id>.txt" in lines_of(name, folder, folder)[1]
