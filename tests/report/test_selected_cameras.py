"""The figure of selected cameras: the geometry of the view and of the outlines, and files for any number of methods."""

import numpy as np
import pytest
from factories import ring

from avs.report.figures.overview import outline_depth, outlines, overview_of
from avs.report.figures.selected_cameras import write_selected_cameras
from avs.scene.cameras import Cameras, look_at
from avs.system.errors import UserError
from tests.report.picture_records import write_episode, written_scene


def in_a_row(count, spread=1.0):
    """Cameras along x that all look along y, with z up."""
    centers = np.stack([spread * np.arange(count), np.zeros(count), np.zeros(count)], axis=1)
    poses = np.stack([look_at(center, center + np.array([0, 1, 0]), np.array([0.0, 0.0, 1.0])) for center in centers])
    matrix = np.array([[20.0, 0, 12.0], [0, 20.0, 8.0], [0, 0, 1]])
    return Cameras(poses, np.tile(matrix, (count, 1, 1)), np.tile(np.array([[24, 16]], dtype=np.int64), (count, 1)))


def test_the_viewer_stands_behind_the_cameras_above_the_horizon():
    overview = overview_of(in_a_row(5))
    np.testing.assert_allclose(np.abs(overview.right), [1, 0, 0], atol=1e-9)
    np.testing.assert_allclose(overview.forward, [0, np.cos(np.radians(40)), -np.sin(np.radians(40))], atol=1e-9)
    assert overview.up @ [0, 0, 1] > 0
    axes = np.stack([overview.right, overview.up, overview.forward])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-9)
    assert overview.flattened(np.array([[0.0, 0, 1]]))[0, 1] > 0


@pytest.mark.parametrize("cameras", [in_a_row(1), in_a_row(4, spread=0.0), ring(7)], ids=["one", "on the spot", "ring"])
def test_any_cameras_have_a_view(cameras):
    overview = overview_of(cameras)
    axes = np.stack([overview.right, overview.up, overview.forward])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-9)
    assert outline_depth(cameras, overview) > 0


def test_an_outline_is_the_centre_and_the_corners_of_the_picture():
    found = outlines(in_a_row(2), 2.0)
    assert found.shape == (2, 5, 3)
    np.testing.assert_allclose(found[1, 0], [1, 0, 0], atol=1e-12)
    # 24 x 16 pixels at a focal length of 20, at a depth of 2: 1.2 and 0.8 to each side.
    corners = [[1 - 1.2, 2, 0.8], [1 + 1.2, 2, 0.8], [1 + 1.2, 2, -0.8], [1 - 1.2, 2, -0.8]]
    np.testing.assert_allclose(found[1, 1:], corners, atol=1e-12)


@pytest.mark.parametrize("count", [1, 3, 24])
def test_any_number_of_methods_gives_the_same_bytes_each_time(tmp_path, count):
    scene, folder = written_scene(tmp_path)
    methods = [f"method-{number}-with-a-long-name-that-no-panel-holds" for number in range(count)]
    paths = [write_episode(tmp_path, scene, method, shift=number) for number, method in enumerate(methods)]
    contents = []
    for name in ("first", "second"):
        write_selected_cameras(paths, folder, methods, "toys", tmp_path / name / "cameras")
        contents.append({path.suffix: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert contents[0] == contents[1]
    assert contents[0].keys() == {".pdf", ".png", ".md"}


def test_a_scene_without_episodes_says_so(tmp_path):
    scene, _ = written_scene(tmp_path)
    _, other = written_scene(tmp_path, "other")
    path = write_episode(tmp_path, scene, "random")
    write_selected_cameras([path], other, ["random"], "toys", tmp_path / "cameras")
    assert "no method has selected views" in (tmp_path / "cameras.md").read_text()


def test_another_version_of_the_scene_is_refused(tmp_path):
    scene, _ = written_scene(tmp_path)
    _, other = written_scene(tmp_path / "other", darkest=20)
    path = write_episode(tmp_path, scene, "random")
    with pytest.raises(UserError, match="is not the scene of random's episode"):
        write_selected_cameras([path], other, ["random"], "toys", tmp_path / "cameras")
