"""One photograph under two names is one view, so that no test photograph is a candidate."""

import shutil
from dataclasses import replace

from factories import small_scene

from avs.datasets.capture_repeats import without_repeats
from avs.scene.colmap import read_model


def test_the_same_bytes_under_a_later_name_are_left_out_with_a_note(tmp_path):
    small_scene(tmp_path / "desk", count=16)
    model = read_model(tmp_path / "desk/sparse/0")
    assert without_repeats(tmp_path / "desk", model) == (model, [])
    names = sorted(image.name for image in model.images.values())
    shutil.copyfile(tmp_path / "desk/images" / names[0], tmp_path / "desk/images/z copy.png")
    number, image = next((number, image) for number, image in model.images.items() if image.name == names[0])
    repeated = replace(model, images=model.images | {number + 100: replace(image, name="z copy.png")})
    left, notes = without_repeats(tmp_path / "desk", repeated)
    assert left.images == model.images
    assert notes == [f"left out, since they are other images once more: z copy.png ({names[0]})"]
