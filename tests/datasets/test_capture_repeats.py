"""One photograph under two names is one view, so that no test photograph is a candidate."""

import shutil
from dataclasses import replace

import numpy as np
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


def with_copy(folder, copy, name):
    """A capture of 16 images, the first of which is there once more; its folder and the names of the others."""
    small_scene(folder, count=16, name="desk")
    (folder / "scene.json").unlink()
    model = read_model(folder / "sparse/0")
    names = sorted(image.name for image in model.images.values())
    copy(folder / "images" / names[0], folder / "images" / name)
    image = next(image for image in model.images.values() if image.name == names[0])
    twice = replace(model, images=model.images | {999: replace(image, name=name)})
    write_model(folder / "sparse/0", twice)
    return folder, names


def compressed(first, second):
    Image.open(first).save(second, quality=60)
    assert not np.array_equal(np.array(Image.open(first)), np.array(Image.open(second)))


def test_a_photograph_saved_again_with_loss_is_left_out_with_a_note(tmp_path):
    def noisy(first, second):
        Image.effect_noise(Image.open(first).size, 60).convert("RGB").save(first)
        compressed(first, second)

    capture, names = with_copy(tmp_path / "desk", noisy, "z copy.jpg")
    prepare(capture, tmp_path / "scene", CaptureSettings())
    scene = read_scene(tmp_path / "scene")
    assert list(scene.names) == names
    told = "left out, since they are nearly other images once more, in pose and picture"
    assert scene.notes[0] == f"{told}: z copy.jpg ({names[0]})"


def another(first, second):
    """Write what could have been taken from the same place at another time."""
    pixels = np.array(Image.open(first))
    pixels[: len(pixels) // 3] //= 2
    Image.fromarray(pixels).save(second)


def test_another_photograph_of_the_same_pose_stays(tmp_path):
    capture, names = with_copy(tmp_path / "desk", another, "z copy.png")
    prepare(capture, tmp_path / "scene", CaptureSettings())
    assert list(read_scene(tmp_path / "scene").names) == [*names, "z copy.png"]


@pytest.mark.parametrize("copy", [shutil.copyfile, rewritten, linked])
def test_the_same_pixels_under_a_later_name_are_left_out_with_a_note(copy, tmp_path):
    capture, names = with_copy(tmp_path / "desk", copy, "z copy.png")
    prepare(capture, tmp_path / "scene", CaptureSettings())
    scene = read_scene(tmp_path / "scene")
    assert list(scene.names) == names
    assert scene.notes[0] == f"left out, since they are other images once more: z copy.png ({names[0]})"
    assert not any("does not register" in note for note in scene.notes)
