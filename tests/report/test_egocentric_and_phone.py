"""The comparison of egocentric photographs with those of a phone: what is measured, and files of any pictures."""

import numpy as np
import pytest
from factories import ring

from avs.report.figures.egocentric_and_phone import write_egocentric_and_phone
from avs.report.figures.image_characteristics import RINGS, characteristics, linear_luminance
from tests.report.picture_records import written_scene


def test_luminance_is_that_of_linear_light():
    image = np.array([[[255, 255, 255], [0, 0, 0], [255, 0, 0], [188, 188, 188]]], dtype=np.uint8)
    np.testing.assert_allclose(linear_luminance(image)[0], [1.0, 0.0, 0.2126, 0.5029], atol=1e-4)


def test_the_field_of_view_is_that_of_the_cameras():
    found = characteristics(ring(3, size=(24, 16)), [np.zeros((16, 24, 3), dtype=np.uint8)])
    np.testing.assert_allclose(found.field_of_view, np.degrees(2 * np.arctan([12 / 20, 8 / 20])))


def test_rings_are_darker_where_the_corners_are():
    rows, columns = np.mgrid[:120, :200]
    distance = np.hypot(rows - 59.5, columns - 99.5)
    dark = np.repeat((255 * (distance < 0.5 * distance.max()))[..., None], 3, axis=2).astype(np.uint8)
    found = characteristics(ring(1), [dark])
    np.testing.assert_allclose(found.rings[: RINGS // 2 - 1], 1.0)
    np.testing.assert_allclose(found.rings[RINGS // 2 + 1 :], 0.0)
    even = characteristics(ring(1), [np.full((3, 2, 3), 255, dtype=np.uint8)])  # fewer pixels than rings
    np.testing.assert_allclose(even.rings, 1.0)
    assert even.luminance == pytest.approx(1.0)


@pytest.mark.parametrize("sizes", [((24, 24), (16, 24)), ((240, 16), (16, 240))])
def test_pictures_of_any_shape_give_the_same_bytes_each_time(tmp_path, sizes):
    folders = [written_scene(tmp_path, f"scene_{row}", size=size, count=14)[1] for row, size in enumerate(sizes)]
    contents = []
    for name in ("first", "second"):
        write_egocentric_and_phone(*folders, tmp_path / name / "figure")
        contents.append({path.suffix: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert contents[0] == contents[1]
    assert contents[0].keys() == {".pdf", ".png", ".md"}
    assert b"scene_1" in contents[0][".md"]
