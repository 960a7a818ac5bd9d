"""``avs data check``: each scene in a line, missing ones named, and a status that scripts can read."""

import shutil

import pytest
from PIL import Image

from avs.config.data_set_check import check_data_set
from avs.system.errors import UserError
from tests.datasets.captures_factory import make_capture


@pytest.fixture
def folder(tmp_path):
    make_capture(tmp_path / "garden")
    make_capture(tmp_path / "room")
    Image.new("RGB", (160, 120), "red").save(tmp_path / "room" / "images" / "image 0.png")
    return tmp_path


def lines_of(name, folder):
    lines = []
    try:
        check_data_set(name, folder, None, lines.append)
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
    lines, _ = lines_of("mipnerf360", folder)
    assert sum("is not there" in line for line in lines) == 7
    assert sum("a smaller copy" in line for line in lines) == 2


@pytest.mark.parametrize(("name", "fault"), [("nosuch", "is unknown; name one of aria_dtc"), ("embedded", "pattern")])
def test_a_name_that_is_no_data_set_in_files_is_refused(name, fault, folder):
    assert fault in lines_of(name, folder)[1]
