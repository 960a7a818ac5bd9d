"""A photograph that lies under the name of another is told by the colours of its points."""

import numpy as np
import pytest

from avs.scene.cameras import Cameras
from avs.scene.photograph_agreement import disagreement_note
from avs.scene.point_colors import pixels_of
from avs.scene.points import Points

NAMES = ("a.png", "b.png", "c.png", "d.png", "e.png")
SIZE = 40


@pytest.fixture
def scene():
    """Points on a plane that five cameras see side by side, photographs of noise, and colours from the first."""
    random = np.random.default_rng(0)
    world_to_camera = np.tile(np.eye(4), (5, 1, 1))
    intrinsics = np.tile(np.array([[SIZE, 0, SIZE / 2], [0, SIZE, SIZE / 2], [0, 0, 1.0]]), (5, 1, 1))
    cameras = Cameras(world_to_camera, intrinsics, np.full((5, 2), SIZE))
    positions = np.column_stack([random.uniform(-0.45, 0.45, (300, 2)), np.ones(300)])
    images = random.integers(0, 256, (5, SIZE, SIZE, 3), dtype=np.uint8)
    observations = np.column_stack([np.arange(300), np.repeat(np.arange(5), 60)])
    colors = np.concatenate(
        [pixels_of(positions[index * 60 : index * 60 + 60], cameras[index], images[index]) for index in range(5)]
    )
    return Points(positions, colors, observations), cameras, images


def test_photographs_of_their_own_views_are_not_told_of(scene):
    points, cameras, images = scene
    darker = (images * 0.4 + 20).astype(np.uint8)  # another exposure
    assert disagreement_note(NAMES, points, cameras, lambda index: darker[index]) is None


def test_exchanged_photographs_are_named(scene):
    points, cameras, images = scene
    order = [0, 3, 2, 1, 4]
    note = disagreement_note(NAMES, points, cameras, lambda index: images[order[index]])
    assert note.startswith("2 of 5 photographs (b.png, d.png) do not show the colours of the points")
    note = disagreement_note(NAMES, points, cameras, lambda index: images[(index + 1) % 5])
    assert note.startswith("5 of 5 photographs (a.png, b.png, c.png and 2 more)")
    assert disagreement_note(NAMES, points, cameras, lambda index: np.zeros_like(images[0])) is not None


@pytest.mark.parametrize("colors", [0, 128])
def test_points_without_colours_of_their_own_tell_nothing(scene, colors):
    points, cameras, images = scene
    plain = Points(points.positions, np.full_like(points.colors, colors), points.observations)
    assert disagreement_note(NAMES, plain, cameras, lambda index: images[index]) is None
