"""The similarity transform between two frames, by the cameras they share."""

import numpy as np
import pytest
from factories import named_views, ring
from scipy.spatial.transform import Rotation
from tolerances import FLOAT64_GEOMETRY

from avs.scene.cameras import Cameras, look_at
from avs.sfm.alignment import Alignment, align, placed
from avs.sfm.cloud import Cloud
from avs.sfm.reconstruction import Reconstruction


def random_alignment(seed=0):
    rotation = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    return Alignment(0.37, rotation, np.array([3.0, -20.0, 5.0]), 0.0, np.ones(0, dtype=bool), False)


def on_a_line(count):
    centers = [np.array([0.3 * number, 0.0, 0.0]) for number in range(count)]
    transforms = np.stack([look_at(c, np.array([1.0, 4.0, 0.2]), np.array([0.0, 0.0, 1.0])) for c in centers])
    return Cameras(transforms, ring(count).intrinsics, ring(count).sizes)


def with_wrong_ones(cameras, rows, seed=0):
    transforms = cameras.world_to_camera.copy()
    transforms[rows, :3, 3] += np.random.default_rng(seed).normal(scale=3.0, size=(len(rows), 3))
    return Cameras(transforms, cameras.intrinsics, cameras.sizes)


@pytest.mark.parametrize("cameras", [ring(12), on_a_line(12), on_a_line(2), ring(3)])
def test_a_known_transform_is_found(cameras):
    known = random_alignment()
    found = align(cameras, known.cameras(cameras))
    assert found.scale == pytest.approx(known.scale, rel=100 * FLOAT64_GEOMETRY)
    np.testing.assert_allclose(found.rotation, known.rotation, atol=100 * FLOAT64_GEOMETRY)
    np.testing.assert_allclose(found.translation, known.translation, atol=1000 * FLOAT64_GEOMETRY)
    assert found.residual < 1000 * FLOAT64_GEOMETRY
    assert found.agree.all()


def test_cameras_see_what_they_saw():
    known, cameras = random_alignment(), ring(5)
    points = np.random.default_rng(0).normal(size=(7, 3))
    before = points @ cameras.world_to_camera[2, :3, :3].T + cameras.world_to_camera[2, :3, 3]
    moved = known.cameras(cameras).world_to_camera[2]
    after = known.points(points) @ moved[:3, :3].T + moved[:3, 3]
    np.testing.assert_allclose(after, known.scale * before, atol=100 * FLOAT64_GEOMETRY)


@pytest.mark.parametrize("cameras", [ring(20), on_a_line(20)])
def test_wrong_cameras_do_not_count(cameras):
    known, wrong = random_alignment(), np.arange(0, 20, 3)
    found = align(with_wrong_ones(cameras, wrong), known.cameras(cameras))
    np.testing.assert_allclose(found.rotation, known.rotation, atol=100 * FLOAT64_GEOMETRY)
    assert not found.agree[wrong].any()
    assert found.agree.sum() == 20 - len(wrong)


def test_the_residual_is_that_of_the_noise():
    cameras, sigma = ring(40), 0.01
    noisy = with_wrong_ones(cameras, np.zeros(0, dtype=int))
    noisy.world_to_camera[:, :3, 3] += np.random.default_rng(0).normal(scale=sigma, size=(40, 3))
    found = align(noisy, cameras)
    assert found.residual == pytest.approx(sigma * np.sqrt(3), rel=0.2)


def test_cameras_that_have_nothing_to_do_with_each_other_do_not_fit():
    assert align(with_wrong_ones(ring(12), np.arange(12)), ring(12)) is None
    assert align(ring(1), ring(1)) is None


def test_a_cloud_is_placed_or_lost_with_its_reason():
    cameras, known = ring(8), random_alignment()
    views = named_views(known.cameras(cameras), [np.zeros((16, 24, 3), dtype=np.uint8)] * 8)
    cloud = Cloud(np.ones((1, 3)), np.zeros((1, 3), dtype=np.uint8), np.ones(1, dtype=np.float32))
    found, alignment = placed(Reconstruction(cloud, views.names, cameras=cameras), views)
    np.testing.assert_allclose(found.cloud.positions, known.points(np.ones((1, 3))), atol=1000 * FLOAT64_GEOMETRY)
    assert alignment.agree.all()
    lost, alignment = placed(Reconstruction(cloud, views.names[:1], cameras=cameras[:1]), views)
    assert alignment is None
    assert len(lost.cloud) == 0
    assert "do not agree" in lost.left_out["000.png"]
