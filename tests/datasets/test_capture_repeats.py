"""One photograph under two names is one view, so that no test photograph is a candidate."""

import shutil
from dataclasses import replace

import pytest
from factories import small_scene
from PIL import Image

from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.captures import prepare
from avs.scene.colmap import read_model, write_model
from avs.scene.scene import read_scene


def rewritten(first, second):
    """Write the same pixels in other bytes."""
    Image.open(first).save(second, compress_level=9)
    assert first.read_bytes() != second.read_bytes()


def linked(first, second):
    second.symlink_to(first)


@pytest.mark.parametrize("copy", [shutil.copyfile, rewritten, linked])
def test_the_same_pixels_under_a_later_name_are_left_out_with_a_note(copy, tmp_path):
    capture = small_scene(tmp_path / "desk", count=16, name="desk")
    capture = tmp_path / "desk"
    (capture / "scene.json").unlink()
    model = read_model(capture / "sparse/0")
    names = sorted(image.name for image in model.images.values())
    copy(capture / "images" / names[0], capture / "images" / "z copy.png")
    image = next(image for image in model.images.values() if image.name == names[0])
    twice = replace(model, images=model.images | {999: replace(image, name="z copy.png")})
    write_model(capture / "sparse/0", twice)
    prepare(capture, tmp_path / "scene", CaptureSettings())
    scene = read_scene(tmp_path / "scene")
    assert list(scene.names) == names
    assert scene.notes[0] == f"left out, since they are other images once more: z copy.png ({names[0]})"
    assert not any("does not register" in note for note in scene.notes)
