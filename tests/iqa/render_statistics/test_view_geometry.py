"""What is known of a view beside its pixels, on a camera ring and made-up depths."""

import numpy as np
import pytest
from factories import ring

from avs.iqa.render_statistics.view_geometry import VIEW_GEOMETRY, view_geometry
from avs.representations.base import Rendering

SIZE = (12, 8)


def rendering(alpha, depth):
    shape = (1, SIZE[1], SIZE[0])
    full = [np.broadcast_to(np.float32(value), shape) for value in (alpha, depth)]
    return Rendering(np.zeros((*shape, 3), np.float32), full[1], full[0])


def named(*arguments):
    return dict(zip(VIEW_GEOMETRY, view_geometry(*arguments)[0], strict=True))


def test_distance_and_angle_are_those_to_the_nearest_captured_camera():
    cameras = ring(8, radius=3.0, size=SIZE)
    found = named(rendering(1.0, 2.0), cameras[[0]], cameras[[1, 4]])
    assert found["distance"] == pytest.approx(2 * 3.0 * np.sin(np.pi / 8))
    directions = cameras.world_to_camera[:, 2, :3]
    assert found["angle"] == pytest.approx(np.arccos(directions[0] @ directions[1]))


def test_a_captured_view_is_at_no_distance():
    cameras = ring(8, size=SIZE)
    found = named(rendering(1.0, 2.0), cameras[[3]], cameras[[1, 3]])
    assert found["distance"] == 0
    assert found["angle"] == pytest.approx(0, abs=1e-6)


def test_depth_is_weighted_by_opacity():
    cameras = ring(8, size=SIZE)
    alpha = np.zeros((1, SIZE[1], SIZE[0]), np.float32)
    depth = np.full_like(alpha, 7.0)
    alpha[0, 0, :4], depth[0, 0, :4] = 0.5, [1.0, 1.0, np.e**2, np.e**2]
    found = named(Rendering(np.zeros((*alpha.shape, 3), np.float32), depth, alpha), cameras[[0]], cameras[[1]])
    assert found["opacity"] == pytest.approx(0.5 * 4 / 96)
    assert found["depth"] == pytest.approx(1.0)
    assert found["depth_spread"] == pytest.approx(1.0)


def test_an_empty_view_has_finite_numbers():
    cameras = ring(8, size=SIZE)
    found = named(rendering(0.0, 0.0), cameras[[0]], cameras[[1]])
    assert (found["opacity"], found["depth"], found["depth_spread"]) == (0, 0, 0)
