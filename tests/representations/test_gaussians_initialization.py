import dataclasses

import numpy as np
import pytest

from avs.representations.gaussians.gaussian_settings import InitialPoints
from avs.representations.gaussians.initialization import initial_points, initial_scales, reference_ball, seen_points
from avs.representations.gaussians.parameters import create_parameters
from avs.scene.scene import Points
from avs.system.errors import UserError
from tests.factories import small_scene


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """40 cameras; point p of 12 is seen by images p, p + 1 and p + 2."""
    return small_scene(tmp_path_factory.mktemp("scenes") / "toy")


def points(scene, captured, **settings):
    generator = np.random.default_rng(0)
    ball = reference_ball(scene, "robust")
    return initial_points(scene, ball, np.array(captured, dtype=np.int64), InitialPoints(**settings), generator)


def test_random_points_fill_a_cube_around_the_cameras(scene):
    cloud = points(scene, [], choice="random", random_count=5000, random_bounds=2.0)
    offsets = (cloud.positions - scene.cameras.centers[scene.pool].mean(axis=0)) / scene.extent
    assert len(offsets) == 5000
    assert 1.9 < np.abs(offsets).max() <= 2.0
    assert np.abs(offsets.mean(axis=0)).max() < 0.1
    assert np.abs(cloud.colors - 0.5).max() < 0.0012
    again = points(scene, [], choice="random", random_count=5000, random_bounds=2.0)
    np.testing.assert_array_equal(cloud.positions, again.positions)


def test_sfm_takes_every_point(scene):
    cloud = points(scene, [], choice="sfm")
    np.testing.assert_array_equal(cloud.positions, scene.points.positions)
    np.testing.assert_array_equal(cloud.colors, scene.points.colors / 255)


@pytest.mark.parametrize(("min_views", "expected"), [(1, range(3, 8)), (2, range(4, 7)), (3, range(5, 6))])
def test_selected_takes_the_points_that_captured_images_see(scene, min_views, expected):
    rows = seen_points(scene.points, np.array([5, 6, 7]), min_views)
    np.testing.assert_array_equal(rows, expected)


def test_an_image_counts_once_for_a_point():
    model = Points(np.zeros((2, 3)), np.zeros((2, 3), np.uint8), np.array([[0, 4], [0, 4], [1, 4], [1, 5]]))
    np.testing.assert_array_equal(seen_points(model, np.array([4, 5]), 2), [1])


@pytest.mark.parametrize("choice", ["sfm", "selected"])
def test_too_few_points_are_an_error_that_names_the_remedy(scene, choice):
    empty = Points(np.zeros((0, 3)), np.zeros((0, 3), np.uint8), np.zeros((0, 2), np.int64))
    with pytest.raises(UserError, match=r"set representation: {points: {choice: random}}"):
        points(dataclasses.replace(scene, points=empty), [0, 1], choice=choice)
    with pytest.raises(UserError, match=r"3 of 12 points .* {points: {choice: sfm or random}}"):
        points(scene, [5], choice="selected")


def test_a_limit_draws_points_at_random(scene):
    cloud = points(scene, [], choice="sfm", max_count=5)
    assert len({tuple(position) for position in cloud.positions} & set(map(tuple, scene.points.positions))) == 5
    assert len(points(scene, [], choice="sfm", max_count=50).positions) == 12


def test_scales_are_root_mean_square_distances_to_three_neighbours():
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3], [9, 9, 9.0]])
    assert initial_scales(positions)[0] == pytest.approx(np.sqrt((1 + 4 + 9) / 3))
    assert initial_scales(np.zeros((5, 3)))[0] == pytest.approx(np.sqrt(1e-7))


def test_scales_of_many_points_have_the_same_bits(monkeypatch):
    positions = np.random.default_rng(0).normal(size=(200, 3))
    few = initial_scales(positions)
    monkeypatch.setattr("avs.representations.gaussians.initialization.MANY_POINTS", 100)
    np.testing.assert_array_equal(initial_scales(positions), few)


@pytest.mark.parametrize("limit", [100, 100_000])
def test_many_coincident_points_take_no_time(monkeypatch, limit):
    monkeypatch.setattr("avs.representations.gaussians.initialization.MANY_POINTS", limit)
    positions = np.concatenate([np.zeros((100_000, 3)), np.random.default_rng(0).normal(size=(150, 3))])
    scales = initial_scales(np.concatenate([positions, positions[-2:]]))
    assert (scales[:100_000] == np.sqrt(1e-7)).all()
    assert (scales[100_000:] > np.sqrt(1e-7)).all()


def test_gaussians_start_with_the_colours_of_the_points(scene):
    import torch

    cloud = points(scene, [], choice="sfm")
    parameters = create_parameters(cloud, 0.1, 2, torch.device("cpu"))
    shapes = {name: tuple(values.shape) for name, values in parameters.items()}
    assert shapes == {"means": (12, 3), "scales": (12, 3), "quats": (12, 4), "opacities": (12,), "sh": (12, 9, 3)}
    colors = parameters["sh"][:, 0].detach().numpy() * 0.28209479177387814 + 0.5
    np.testing.assert_allclose(colors, cloud.colors, atol=1e-6)
    np.testing.assert_allclose(torch.sigmoid(parameters["opacities"]).detach().numpy(), 0.1, atol=1e-6)
