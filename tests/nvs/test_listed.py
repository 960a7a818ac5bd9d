"""Episodes on views that a file lists."""

import json

import numpy as np
import pytest
from factories import MeanColor, small_scene

from avs.nvs.program import read_views
from avs.scene.sampling import initial_views
from avs.selection.contract import State
from avs.system.errors import UserError


@pytest.fixture
def scene(tmp_path):
    return small_scene(tmp_path / "scene", count=16)


@pytest.fixture
def listed(scene, tmp_path):
    """Write a list of views and return the selector that follows it."""

    def write(views, **changes):
        path = tmp_path / "views.json"
        path.write_text(json.dumps({"label": "Theirs", "views": views} | changes))
        return read_views(path, initial(scene), {scene.names[index] for index in scene.pool})

    return write


def state_of(scene, captured, step=0):
    names = [name for name in scene.names if name not in captured]
    candidates = np.array([i for i in scene.pool if scene.names[i] in names])
    rows = [scene.names.index(name) for name in captured]
    left = tuple(scene.names[i] for i in candidates)
    rng = np.random.default_rng(0)
    return State(MeanColor(), scene.views(rows), scene.cameras[candidates], left, rng, step), left


def initial(scene):
    return [scene.names[i] for i in scene.pool[initial_views(scene.cameras[scene.pool].centers, 3)]]


def test_views_are_taken_in_order_and_captured_ones_passed_over(scene, listed):
    start = initial(scene)
    others = [scene.names[i] for i in scene.pool if scene.names[i] not in start]
    views, selector = listed([others[4], start[0], others[1], others[4], others[7]])
    assert (views.label, views.group) == ("Theirs", "2D-based")
    captured = list(start)
    for step, expected in enumerate([others[4], others[1], others[7]]):
        state, candidates = state_of(scene, captured, step)
        selection = selector.select(state, 1)
        assert [candidates[row] for row in selection.indices] == [expected]
        assert selection.scores is None
        captured.append(expected)


def test_a_test_image_is_refused_in_one_line(scene, listed):
    others = [scene.names[i] for i in scene.pool]
    with pytest.raises(UserError, match=r"views.json: 000.png, nonsense.png: no view of the pool; list images that"):
        listed([*others, scene.names[scene.test[0]], "nonsense.png"])


def test_a_list_that_is_too_short_is_one_line(scene, listed):
    others = [scene.names[i] for i in scene.pool if scene.names[i] not in initial(scene)]
    _, selector = listed(others[:1])
    with pytest.raises(UserError, match=r"views.json: lists too few views at step 0"):
        selector.select(state_of(scene, initial(scene))[0], 2)


@pytest.mark.parametrize(
    ("views", "changes", "fault"),
    [
        (["a.png"], {"view": []}, "view: unknown key"),
        ([], {}, "views: must have at least 1"),
        (["a.png"], {"label": ""}, "label: String"),
    ],
)
def test_a_faulty_file_is_one_line(listed, views, changes, fault):
    with pytest.raises(UserError, match=fault) as error:
        listed(views, **changes)
    assert "\n" not in str(error.value)
