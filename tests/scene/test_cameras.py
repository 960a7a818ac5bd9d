"""Cameras: conventions, checks, resizing."""

import numpy as np
import pytest

from avs.scene.cameras import Cameras, concatenate, look_at
from tests import tolerances


def cameras(count=3):
    generator = np.random.default_rng(0)
    centers = generator.normal(size=(count, 3)) * 4
    transforms = np.stack([look_at(center, np.zeros(3), np.array([0.0, 0.0, 1.0])) for center in centers])
    intrinsics = np.tile(np.array([[100.0, 0, 40], [0, 110.0, 30], [0, 0, 1]]), (count, 1, 1))
    return Cameras(transforms, intrinsics, np.tile(np.array([[80, 60]]), (count, 1))), centers


def test_look_at_puts_the_target_in_the_middle_and_up_above():
    batch, centers = cameras()
    for transform, center in zip(batch.world_to_camera, centers, strict=True):
        target, above = (transform @ [*point, 1.0] for point in (np.zeros(3), np.array([0.0, 0.0, 0.1])))
        np.testing.assert_allclose(target[:3], [0, 0, np.linalg.norm(center)], atol=tolerances.FLOAT64_GEOMETRY)
        assert above[1] < 0  # y points down
        rotation = transform[:3, :3]
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=tolerances.FLOAT64_GEOMETRY)
        assert np.linalg.det(rotation) > 0


def test_centers_are_where_the_cameras_were_put():
    batch, centers = cameras()
    np.testing.assert_allclose(batch.centers, centers, atol=tolerances.FLOAT64_GEOMETRY)


@pytest.mark.parametrize(("center", "up"), [(np.zeros(3), [0, 0, 1.0]), (np.array([0, 0, 2.0]), [0, 0, 1.0])])
def test_look_at_refuses_an_undefined_direction(center, up):
    with pytest.raises(ValueError, match="undefined"):
        look_at(center, np.zeros(3), np.array(up))


def test_resizing_keeps_where_a_point_lies_relative_to_the_image():
    batch, _ = cameras()
    sizes = np.array([[40, 31], [79, 60], [80, 60]])
    point = np.array([0.1, -0.2, 0.3, 1.0])

    def relative(some):
        local = np.einsum("nij,j->ni", some.world_to_camera, point)[:, :3]
        pixels = np.einsum("nij,nj->ni", some.intrinsics, local / local[:, 2:])[:, :2]
        return pixels / some.sizes

    np.testing.assert_allclose(relative(batch.resized(sizes)), relative(batch), rtol=tolerances.FLOAT64_GEOMETRY)
    assert batch.resized(sizes).sizes.dtype == np.int64


def test_by_size_keeps_order_of_appearance():
    batch, _ = cameras(4)
    batch = batch.resized(np.array([[8, 6], [4, 3], [8, 6], [4, 3]]))
    groups = [(size, list(rows)) for size, rows in batch.by_size()]
    assert groups == [((8, 6), [0, 2]), ((4, 3), [1, 3])]


def test_indexing_and_concatenation_are_inverse():
    batch, _ = cameras(4)
    joined = concatenate([batch[0], batch[1:3], batch[np.array([3])]])
    np.testing.assert_array_equal(joined.world_to_camera, batch.world_to_camera)
    assert len(batch[[]]) == 0


@pytest.mark.parametrize("field", ["world_to_camera", "intrinsics"])
def test_not_a_number_is_refused(field):
    batch, _ = cameras()
    values = {name: getattr(batch, name).copy() for name in ("world_to_camera", "intrinsics", "sizes")}
    values[field][1, 0, 0] = np.nan
    with pytest.raises(ValueError, match=field):
        Cameras(**values)


def test_wrong_shape_is_refused():
    batch, _ = cameras()
    with pytest.raises(ValueError, match="shape"):
        Cameras(batch.world_to_camera, batch.intrinsics[:2], batch.sizes)
