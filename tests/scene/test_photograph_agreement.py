"""A photograph that lies under the name of another is told by the colours of its points."""

import numpy as np
import pytest

from avs.scene.cameras import Cameras
from avs.scene.photograph_agreement import disagreement_notes
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
    assert disagreement_notes(NAMES, points, cameras, lambda index: darker[index]) == []


def test_pixels_of_a_small_picture_may_be_of_several_points(scene):
    """As kitchen at 176 pixels, where a good photograph has .55."""
    points, cameras, images = scene
    others = np.random.default_rng(1).uniform(0, 255, points.colors.shape)
    mixed = Points(points.positions, (0.4 * points.colors + 0.6 * others).astype(np.uint8), points.observations)
    assert disagreement_notes(NAMES, mixed, cameras, lambda index: images[index]) == []
    large = Cameras(cameras.world_to_camera, cameras.intrinsics, np.full((5, 2), 320))
    (note,) = disagreement_notes(NAMES, mixed, large, lambda index: images[index])
    assert "do not show the colours of the points" in note


def test_exchanged_photographs_are_named(scene):
    points, cameras, images = scene
    order = [0, 3, 2, 1, 4]
    (note,) = disagreement_notes(NAMES, points, cameras, lambda index: images[order[index]])
    assert note.startswith("2 of 5 photographs (b.png, d.png) do not show the colours of the points")
    (note,) = disagreement_notes(NAMES, points, cameras, lambda index: images[(index + 1) % 5])
    assert note.startswith("5 of 5 photographs (a.png, b.png, c.png and 2 more)")
    assert disagreement_notes(NAMES, points, cameras, lambda index: np.zeros_like(images[0]))


@pytest.mark.parametrize("colors", [0, 128])
def test_points_without_colours_of_their_own_tell_nothing(scene, colors):
    points, cameras, images = scene
    plain = Points(points.positions, np.full_like(points.colors, colors), points.observations)
    assert disagreement_notes(NAMES, plain, cameras, lambda index: images[index]) == []


def masked(image):
    return np.where(np.arange(SIZE)[:, None, None] > 0.6 * SIZE, 128, image).astype(np.uint8)


CHANGES = {
    "have the colours of the points that they observe as BGR in place of RGB": lambda image: image[..., ::-1],
    "have the colours of the points that they observe as GBR in place of RGB": lambda image: image[..., [1, 2, 0]],
    "have one and the same colour where the points that they observe have several": masked,
    "are less than half as bright": lambda image: image // 4,
}


@pytest.mark.parametrize("told", CHANGES)
def test_all_photographs_with_other_colours_than_their_points_are_named(scene, told):
    points, cameras, images = scene
    changed = [CHANGES[told](image) if index < 3 else image for index, image in enumerate(images)]
    (note,) = disagreement_notes(NAMES, points, cameras, lambda index: changed[index])
    assert note.startswith(f"3 of 5 photographs (a.png, b.png, c.png) {told}")


def test_brighter_photographs_are_named_and_burnt_out_ones_are_not(scene):
    points, cameras, images = scene
    dark = Points(points.positions, points.colors // 3, points.observations)
    (note,) = disagreement_notes(NAMES, dark, cameras, lambda index: images[index])
    assert note.startswith("5 of 5 photographs (a.png, b.png, c.png and 2 more) are more than twice as bright")
    white = np.where(np.arange(SIZE)[:, None] > 0.6 * SIZE, 255, 0)[..., None]
    burnt = np.maximum(images, white).astype(np.uint8)
    colors = np.concatenate([pixels_of(points.positions[60 * n : 60 * n + 60], cameras[n], burnt[n]) for n in range(5)])
    own = Points(points.positions, colors, points.observations)
    assert disagreement_notes(NAMES, own, cameras, lambda index: burnt[index]) == []


def test_what_is_known_to_be_masked_is_not_named(scene):
    points, cameras, images = scene
    note = disagreement_notes(NAMES, points, cameras, lambda index: masked(images[index]), NAMES[:4])
    assert [each.split(" photographs ")[0] for each in note] == ["1 of 5"]
