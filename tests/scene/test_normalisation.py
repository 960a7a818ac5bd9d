"""A scene's own unit and origin, stray cameras, and points that came without colours."""

import numpy as np
import pytest

from avs.scene.cameras import Cameras
from avs.scene.normalisation import EXTENT, camera_ball, stray_cameras
from avs.scene.points import Points
from avs.scene.scene import read_scene, write_scene
from avs.scene.similarity import Similarity
from avs.system.errors import UserError
from tests import tolerances
from tests.factories import ring

MOVES = {
    "as it is": Similarity(scale=1, translation=(0, 0, 0)),
    "tiny": Similarity(scale=1e-3, translation=(0, 0, 0)),
    "huge, far": Similarity(scale=1e3, translation=(4e6, -4e6, 1e5)),
    "georeferenced": Similarity(scale=1, translation=(4.1e6, 6.3e5, 4.8e6)),
}


def write(folder, cameras, test=(0, 8), **changes):
    """Write a scene of flat pictures and read it back."""
    rng = np.random.default_rng(0)
    count = len(cameras)
    points = Points(rng.normal(size=(6, 3)), rng.integers(1, 255, (6, 3), np.uint8), np.zeros((0, 2), np.int64))
    parts = {
        "name": "toy",
        "dataset": "toys",
        "names": [f"{index:03d}.png" for index in range(count)],
        "images": [np.full((16, 24, 3), 9 * index, np.uint8) for index in range(count)],
        "test": np.array(test),
        "points": points,
        "source": "capture toy",
        "licence": "none",
    }
    write_scene(folder, cameras=cameras, **(parts | changes))
    return read_scene(folder)


def with_center(cameras, index, center):
    """Return cameras of which one stands elsewhere."""
    transforms = cameras.world_to_camera.copy()
    transforms[index, :3, 3] = -transforms[index, :3, :3] @ center
    return Cameras(transforms, cameras.intrinsics, cameras.sizes)


@pytest.mark.parametrize("move", MOVES)
def test_unit_and_origin_of_the_capture_leave_no_trace(move, tmp_path):
    points = Points(np.random.default_rng(1).normal(size=(6, 3)), np.eye(6, 3, dtype=np.uint8), np.array([[0, 1]]))
    plain = write(tmp_path / "plain", ring(12), points=points)
    there = Points(MOVES[move].points(points.positions), points.colors, points.observations)
    scene = write(tmp_path / "moved", MOVES[move].cameras(ring(12)), points=there)
    # 4e6 units from the origin float64 resolves 1e-9 of them
    np.testing.assert_allclose(scene.points.positions, plain.points.positions, atol=1e-8)
    np.testing.assert_allclose(scene.cameras.world_to_camera, plain.cameras.world_to_camera, atol=1e-8)
    np.testing.assert_allclose(scene.to_capture.points(scene.points.positions), there.positions, rtol=1e-14, atol=1e-12)


def test_the_extent_is_that_of_3dgs(tmp_path):
    scene = write(tmp_path / "toy", ring(12))
    middle, extent = camera_ball(scene.cameras.centers[scene.pool])
    assert scene.extent == EXTENT == pytest.approx(extent, rel=tolerances.FLOAT64_GEOMETRY)
    np.testing.assert_allclose(middle, 0, atol=tolerances.FLOAT64_GEOMETRY)
    given = ring(12).centers[scene.pool]
    radius = np.linalg.norm(given - given.mean(axis=0), axis=1).max()
    assert scene.to_capture.scale * scene.extent == pytest.approx(1.1 * radius)


def test_a_similarity_and_its_inverse():
    similarity, cameras = MOVES["huge, far"], ring(5)
    there = similarity.cameras(cameras)
    np.testing.assert_allclose(there.centers, similarity.points(cameras.centers), atol=1e-8)
    np.testing.assert_allclose(similarity.cameras_back(there).world_to_camera, cameras.world_to_camera, atol=1e-11)
    np.testing.assert_allclose(similarity.points_back(similarity.points(cameras.centers)), cameras.centers, atol=1e-11)


@pytest.mark.parametrize("index", [8, 5])
def test_a_stray_camera_is_named_and_changes_nothing_else(index, tmp_path):
    cameras = with_center(ring(16), index, np.array([3000.0, 0, 0]))
    scene = write(tmp_path / "toy", cameras)
    assert any(f"{index:03d}.png" in note and "stray" in note for note in scene.notes)
    kept = np.setdiff1d(scene.pool, [index])
    assert np.linalg.norm(scene.cameras.centers[kept], axis=1).max() < EXTENT
    assert len(scene.names) == 16
    assert len(scene.pool) == 14


@pytest.mark.parametrize("distance", [1e5, 1e12, 1e14])
def test_a_camera_however_far_out_is_stray(distance, tmp_path):
    scene = write(tmp_path / "toy", with_center(ring(16), 5, np.array([distance, 0, 0])))
    assert any("005.png" in note for note in scene.notes)
    plain = write(tmp_path / "plain", with_center(ring(16), 5, np.array([3000.0, 0, 0])))
    np.testing.assert_allclose(scene.to_capture.scale, plain.to_capture.scale, rtol=tolerances.FLOAT64_GEOMETRY)


@pytest.mark.parametrize("distance", [1e20, 1e200, 1e308])
def test_what_lies_too_far_out_is_told_in_one_line(distance, tmp_path):
    with pytest.raises(UserError, match=r"^capture toy: a camera lies more than .*; take that camera out of the model"):
        write(tmp_path / "toy", with_center(ring(16), 5, np.array([distance, 0, 0])))
    points = Points(np.array([[0, 0, 0], [0, distance, 0]]), np.eye(2, 3, dtype=np.uint8), np.zeros((0, 2), np.int64))
    with pytest.raises(UserError, match=r"^capture toy: a point lies more than .*; take that point out of the model"):
        write(tmp_path / "toy", ring(16), points=points)


def test_no_ordinary_camera_is_stray():
    rng = np.random.default_rng(0)
    walk = np.cumsum(rng.normal(size=(100, 3)), axis=0)
    ball, line = rng.normal(size=(30, 3)), np.linspace(0, 1, 50)[:, None] * np.ones(3)
    two_places = np.repeat([[0.0, 0, 0], [1, 0, 0]], [60, 40], axis=0)
    assert not any(stray_cameras(move.points(walk)).any() for move in MOVES.values())
    for centers in (walk, ball, line, two_places, ball[:1], ball[:2], np.zeros((5, 3))):
        assert not stray_cameras(centers).any()
    mostly_one = np.concatenate([np.zeros((95, 3)), rng.normal(size=(5, 3))])
    assert not stray_cameras(mostly_one).any()


@pytest.mark.parametrize("place", [(0, 0, 0), (1, 2, 3), (4.1e6, 6.3e5, 4.8e6)])
def test_cameras_in_one_place_are_refused_in_one_line(place, tmp_path):
    cameras = ring(16)
    for index in range(16):
        cameras = with_center(cameras, index, np.array(place))
    with pytest.raises(
        UserError, match=r"^capture toy: its cameras .* stand in one place; take photographs from"
    ) as told:
        write(tmp_path / "toy", cameras)
    assert "\n" not in str(told.value)
    assert list(tmp_path.iterdir()) == []


def test_points_without_colours_take_those_of_the_photographs(tmp_path):
    # Points 0 and 1 are seen by images 1 to 3, point 2 by the test image alone, point 3 by none.
    observations = np.array([[0, 1], [0, 2], [1, 3], [2, 0]])
    points = Points(np.zeros((4, 3)), np.zeros((4, 3), np.uint8), observations)
    scene = write(tmp_path / "toy", ring(12), points=points)
    # image i has the colour 9 i
    expected = [[14] * 3, [27] * 3, [128] * 3, [128] * 3]
    np.testing.assert_array_equal(scene.points.colors, expected)
    note = "4 of 4 points came without colours: 2 took those of the photographs, 2 that none observes are grey"
    assert note in scene.notes


def test_the_colour_is_that_of_the_pixel_that_sees_the_point(tmp_path):
    rng = np.random.default_rng(0)
    images = rng.integers(1, 255, (12, 16, 24, 3), np.uint8)
    points = Points(rng.normal(size=(5, 3)) / 9, np.zeros((5, 3), np.uint8), np.array([[p, p + 1] for p in range(5)]))
    scene = write(tmp_path / "toy", ring(12), points=points, images=list(images))
    for index, position in enumerate(points.positions):
        x, y, z = (ring(12).world_to_camera[index + 1] @ [*position, 1])[:3]
        pixel = images[index + 1, int(20 * y / z + 8), int(20 * x / z + 12)]
        np.testing.assert_array_equal(scene.points.colors[index], pixel)


def test_the_photographs_tell_whether_a_point_is_black(tmp_path):
    # image i has the colour 9 i: point 0 is dark, point 1 has a colour, point 2 has lost its own, no image sees point 3
    colors = np.array([[0, 0, 0], [9, 0, 9], [0, 0, 0], [0, 0, 0]], np.uint8)
    points = Points(np.zeros((4, 3)), colors, np.array([[0, 2], [1, 2], [2, 9]]))
    scene = write(tmp_path / "toy", ring(12), points=points)
    np.testing.assert_array_equal(scene.points.colors, [[0, 0, 0], [9, 0, 9], [81, 81, 81], [0, 0, 0]])
    assert scene.notes == ("1 of 4 points came without colours: 1 took those of the photographs",)
