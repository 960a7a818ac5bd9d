"""The live view: what it shows, on a stand-in for the package that serves it, and that it serves this machine alone."""

import dataclasses
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from avs.nvs.record import Episode
from avs.report.page.live_view import camera_colors, covariances, quaternion, serve_episode
from avs.representations.gaussians.ply import write_ply
from avs.system.errors import UserError
from avs.system.records import read_record, write_record
from tests.report.picture_records import write_episode, written_scene
from tests.representations.test_ply import gaussians


class StandIn:
    """Records what it is asked to show."""

    def __init__(self, **options):
        self.options, self.shown, self.slider = options, {}, None
        self.scene = self.gui = self

    def set_up_direction(self, direction):
        self.up = direction

    def add_gaussian_splats(self, name, **arrays):
        self.shown[name] = arrays

    def add_point_cloud(self, name, *arrays, **options):
        self.shown[name] = arrays

    def add_camera_frustum(self, name, **told):
        self.shown[name] = told

    def remove_by_name(self, name):
        self.shown = {key: value for key, value in self.shown.items() if not key.startswith(name)}

    def add_slider(self, name, initial_value, **options):
        self.slider = SimpleNamespace(value=initial_value, on_update=lambda draw: setattr(self, "draw", draw))
        return self.slider


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", SimpleNamespace(ViserServer=StandIn))
    scene, folder = written_scene(tmp_path)
    path = write_episode(tmp_path, scene, "random")
    write_ply(path.with_name("splats.ply"), gaussians(count=9), scene.to_capture)
    return path, folder, scene


def test_it_serves_this_machine_alone_with_the_model_and_the_cameras(run):
    path, folder, scene = run
    server = serve_episode(path, folder, 8123)
    assert (server.options["host"], server.options["port"]) == ("127.0.0.1", 8123)
    assert server.shown["/model"]["covariances"].shape == (9, 3, 3)
    cameras = [name for name in server.shown if name.startswith("/cameras/")]
    assert len(cameras) == len(scene.test) + 7, "test views and all that were captured; no candidate is left to score"
    server.slider.value = 1
    server.draw()
    assert len([name for name in server.shown if name.startswith("/cameras/")]) == len(scene.names)


def test_names_that_agree_but_for_their_folder_are_cameras_of_their_own(run, monkeypatch):
    path, folder, scene = run
    episode = read_record(path, Episode)
    named = {name: f"{'ab'[number % 2]}/{number // 2:03d}.png" for number, name in enumerate(scene.names)}
    renamed = dataclasses.replace(scene, names=tuple(named.values()))
    monkeypatch.setattr("avs.report.page.live_view.read_scene", lambda folder: renamed)
    steps = [
        step.model_copy(
            update={
                "candidates": [named[name] for name in step.candidates],
                "chosen": [named[name] for name in step.chosen],
            }
        )
        for step in episode.steps
    ]
    initial = [named[name] for name in episode.initial]
    write_record(path, episode.model_copy(update={"steps": steps, "initial": initial}))
    server = serve_episode(path, folder, 8123)
    assert len([name for name in server.shown if name.startswith("/cameras/")]) == len(scene.test) + 7


def test_colours_tell_the_order_and_the_scores(run):
    path, _, scene = run
    episode = read_record(path, Episode)
    first = camera_colors(episode, scene, 0)
    assert first[episode.initial[0]] == (32, 38, 44)
    assert first[episode.selected[0]] == (213, 72, 11)
    scores = dict(zip(episode.steps[0].candidates, episode.steps[0].scores, strict=True))
    lowest = min((name for name in scores if name not in episode.steps[0].chosen), key=scores.get)
    highest = max(scores, key=scores.get)
    assert first[highest] == (244, 200, 60)
    assert first[lowest][2] > first[lowest][0], "blue"
    end = camera_colors(episode, scene, len(episode.steps))
    assert [end[name] for name in episode.selected] == [(11, 92, 173)] * 3


def test_the_shape_of_a_gaussian_is_that_of_its_rotation_and_scales():
    quats = gaussians(count=5)["quats"].numpy().astype(float)
    found = covariances(quats, np.tile([1.0, 2.0, 3.0], (5, 1)))
    np.testing.assert_allclose(np.linalg.eigvalsh(found), np.tile([1.0, 4.0, 9.0], (5, 1)), rtol=1e-9)
    half = np.sqrt(0.5)  # a quarter turn about z: x goes to y
    turned = covariances(np.array([[half, 0, 0, half]]), np.array([[3.0, 1.0, 1.0]]))[0]
    np.testing.assert_allclose(turned, np.diag([1.0, 9.0, 1.0]), atol=1e-12)
    np.testing.assert_allclose(quaternion(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])), [half, 0, 0, half])


def test_without_the_package_it_says_how_to_get_it(run, monkeypatch):
    path, folder, _ = run
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(UserError, match="not installed; pip install --no-deps --requirement environment-optional"):
        serve_episode(path, folder, 8080)


def test_the_scene_of_another_episode_is_refused(run, tmp_path):
    path, _, _ = run
    _, other = written_scene(tmp_path, name="attic")
    with pytest.raises(UserError, match="is not the scene of the episode"):
        serve_episode(path, other, 8080)
