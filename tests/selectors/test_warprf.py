"""WarpRF against its formula in plain loops over pixels, in float64."""

import math

import numpy as np
import pytest
from factories import OnlyRenders, named_views, ring, selected, state_of
from tolerances import WARPING

from avs.representations.base import Rendering
from avs.scene.cameras import Cameras, concatenate
from avs.selection.contract import Resources, Settings
from avs.selectors.warprf import WarpRfSelector

CAPTURED = 3


class Pictures:
    """Renders a random picture, depth and opacity for each camera; depths reach to and beyond the other cameras."""

    def __init__(self, cameras, depth_range=(1.0, 7.0)):
        self._centers = cameras.centers
        rng = np.random.default_rng(1)
        self.pictures = []
        for width, height in cameras.sizes:
            size = (height, width)
            rgb, depth, alpha = rng.random((*size, 3)), rng.uniform(*depth_range, size), rng.uniform(0.3, 1, size)
            alpha[0, 0] = depth[0, 0] = 0
            self.pictures.append([x.astype(np.float32) for x in (rgb, depth, alpha)])
        self.calls = 0

    def render(self, cameras):
        rows = [int(np.argmin(np.linalg.norm(self._centers - center, axis=1))) for center in cameras.centers]
        self.calls += len(rows)
        return Rendering(*(np.stack([self.pictures[row][part] for row in rows]) for part in range(3)))


def select(cameras, representation, k=1):
    images = tuple(np.zeros((height, width, 3), np.uint8) for width, height in cameras.sizes[:CAPTURED])
    captured, candidates = named_views(cameras[:CAPTURED], images), cameras[CAPTURED:]
    state = state_of(OnlyRenders(representation), captured, candidates, np.random.default_rng(0), 0)
    return selected("warprf", WarpRfSelector(Settings(), Resources()), state, k)


def bilinear(image, x, y):
    """Return the colour at (x, y), pixel centres at half integers, held at the edge pixels' centres."""
    height, width, _ = image.shape
    x, y = min(max(x - 0.5, 0), width - 1), min(max(y - 0.5, 0), height - 1)
    left, top = min(int(x), width - 2) if width > 1 else 0, min(int(y), height - 2) if height > 1 else 0
    right, bottom = min(left + 1, width - 1), min(top + 1, height - 1)
    u, v = x - left, y - top
    above = (1 - u) * image[top, left] + u * image[top, right]
    return (1 - v) * above + v * ((1 - u) * image[bottom, left] + u * image[bottom, right])


def twin(cameras, pictures, candidate):
    """Return the sum over pixels of the least L1 distance to a captured picture at the pixel's point."""
    rgb, depth, alpha = (part.astype(np.float64) for part in pictures[candidate])
    total = 0.0
    for row in range(rgb.shape[0]):
        for column in range(rgb.shape[1]):
            pixel = np.array([column + 0.5, row + 0.5, 1.0])
            blended = np.float64(np.float32(depth[row, column]) * np.float32(alpha[row, column]))
            point = np.append(np.linalg.inv(cameras.intrinsics[candidate]) @ pixel * blended, 1.0)
            world = np.linalg.inv(cameras.world_to_camera[candidate]) @ point
            distances = []
            for view in range(CAPTURED):
                x, y, z = cameras.intrinsics[view] @ (cameras.world_to_camera[view] @ world)[:3]
                seen = bilinear(pictures[view][0].astype(np.float64), x / z, y / z)
                distances.append(math.fsum(abs(seen - rgb[row, column])))
            total += min(distances)
    return total


def turned(cameras):
    """Turn every second camera by a third of a circle: much projects outside, or behind."""
    angle = 2 * np.pi / 3
    turn = np.eye(4)
    turn[:3, :3] = [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    transforms = cameras.world_to_camera.copy()
    transforms[::2] = turn @ transforms[::2]
    return Cameras(transforms, cameras.intrinsics, cameras.sizes)


@pytest.mark.parametrize("arrange", [lambda cameras: cameras, turned])
def test_scores(arrange):
    cameras = arrange(ring(8, size=(12, 9)))
    representation = Pictures(cameras)
    selection = select(cameras, representation)
    scores = [twin(cameras, representation.pictures, row) for row in range(CAPTURED, 8)]
    np.testing.assert_allclose(selection.scores, scores, rtol=WARPING)
    assert selection.indices.tolist() == [int(np.argmax(scores))]
    assert representation.calls == 8, "each view is rendered once"
    every = select(cameras, representation, k=5)
    assert every.indices.tolist() == np.argsort(-np.array(scores)).tolist()


def test_views_of_several_sizes():
    cameras = concatenate([ring(7, size=(12, 9))[:2], ring(7, size=(8, 11))[2:5], ring(7, size=(12, 9))[5:]])
    representation = Pictures(cameras)
    selection = select(cameras, representation)
    scores = [twin(cameras, representation.pictures, row) for row in range(CAPTURED, 7)]
    np.testing.assert_allclose(selection.scores, scores, rtol=WARPING)


def test_a_candidate_at_a_captured_place_agrees_with_it():
    cameras = ring(5, size=(12, 9))
    cameras = cameras[[0, 1, 2, 1, 3]]
    representation = Pictures(ring(5, size=(12, 9)))
    _, depth, alpha = representation.pictures[1]
    depth[0, 0] = alpha[0, 0] = 1
    selection = select(cameras, representation)
    assert selection.scores[0] < WARPING * selection.scores[1]


def test_points_in_the_plane_of_a_captured_centre_give_finite_scores():
    """They project to infinity."""
    cameras = ring(4, size=(12, 9))
    transforms = cameras.world_to_camera.copy()
    transforms[3] = transforms[0]
    cameras = Cameras(transforms, cameras.intrinsics, cameras.sizes)
    representation = Pictures(cameras, depth_range=(0.0, 0.0))
    assert np.isfinite(select(cameras, representation).scores).all()
