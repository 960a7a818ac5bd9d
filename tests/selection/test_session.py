"""The session that captures views: what a method does to what it is shown stays with the method."""

import numpy as np
import pytest
from factories import MeanColor, small_scene

from avs.representations import kinds
from avs.selection import registry
from avs.selection.contract import Resources
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


@pytest.mark.parametrize("write", ["parameters", "photographs"])
def test_a_method_that_writes_into_what_it_is_shown_is_refused_by_name(tmp_path, write):
    """Neither way is seen by a count of versions or by a mark of being read-only."""

    class Writer:
        def score(self, state):
            if write == "parameters":
                state.representation.inner.parameters["means"].data[0] += 1
            else:
                state.captured.images[0].setflags(write=True)
                state.captured.images[0][0, 0] ^= 1
            return np.zeros(len(state.candidates))

    scene = small_scene(tmp_path / "toy", count=16)
    settings = kinds.create_settings({"kind": "gaussians", "points": {"choice": "random", "random_count": 20}})
    session = Session(scene, lambda captured: kinds.build(scene, captured, settings, 0, "cpu"), scene.pool[:4])
    state, method = session.state(np.random.default_rng(0), step=0), registry.find("random").method
    timed_selection(method, method.selector(method.settings(), Resources()), state, 1, "cpu")
    told = {"parameters": "the reconstruction", "photographs": "the photographs"}[write]
    with pytest.raises(UserError, match=f"method Random: wrote into {told} that it was shown; let it work on a copy"):
        timed_selection(method, Writer(), state, 1, "cpu")
