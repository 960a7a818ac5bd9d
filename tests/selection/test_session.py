"""The session that captures views: what a method does to what it is shown stays with the method."""

import numpy as np
import pytest
from factories import MeanColor, small_scene

from avs.selection import registry
from avs.selection.session import Session, timed_selection
from avs.system.errors import UserError


def test_cameras_that_a_method_changes_in_place_are_not_those_of_the_training(tmp_path):
    scene = small_scene(tmp_path / "toy", count=16)
    session = Session(scene, lambda captured: MeanColor(), scene.pool[:4])
    poses = session.views.cameras.world_to_camera.copy()
    shown = session.state(np.random.default_rng(0), step=0)
    shown.captured.cameras.world_to_camera[:, 1:3] *= -1
    shown.candidates.world_to_camera[:] = 0
    np.testing.assert_array_equal(session.views.cameras.world_to_camera, poses)
    np.testing.assert_array_equal(scene.cameras.world_to_camera[scene.pool[:4]], poses)


def test_a_method_that_goes_on_fitting_what_it_is_shown_is_refused_by_name(tmp_path):
    class Greedy:
        def score(self, state):
            state.representation.inner.iteration += 50
            return np.zeros(len(state.candidates))

    scene = small_scene(tmp_path / "toy", count=16)
    session = Session(scene, lambda captured: MeanColor(), scene.pool[:4])
    session.representation.iteration = 7
    state = session.state(np.random.default_rng(0), step=0)
    with pytest.raises(UserError, match="method Random: went on fitting the reconstruction that it was shown"):
        timed_selection(registry.find("random").method, Greedy(), state, 1, "cpu")
