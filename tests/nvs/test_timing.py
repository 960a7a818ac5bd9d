"""The measurement of selection times: which situations a method is timed in. No test asks how long anything takes."""

import numpy as np
import pytest
from factories import small_scene

from avs.nvs.protocol import ProtocolSettings
from avs.nvs.timing import device_of, time_method, write_state
from avs.nvs.timing_record import Runtime
from avs.nvs.timing_settings import RuntimeSettings, StateSettings, TimingSettings
from avs.representations.gaussians.gaussian_settings import Densification, GaussianSettings, InitialPoints
from avs.scene.sampling import initial_views
from avs.selection import registry
from avs.selection.choice import choose
from avs.selection.contract import Method, Selection
from avs.selection.registry import Registered
from avs.system.errors import UserError
from avs.system.records import read_record

PROTOCOL = ProtocolSettings(initial_views=3, budget=8, additions=(2, 3, 4, 6, 8), iterations=20)
REPRESENTATION = GaussianSettings(
    iterations=20, sh_degree=0, points=InitialPoints(choice="sfm"), densification=Densification(start=500)
)
SHARED = {"device": "cpu", "protocol": PROTOCOL, "representation": REPRESENTATION}


class Spy:
    """Chooses the first candidates; keeps what it was shown."""

    def __init__(self):
        self.states = []
        self.prepared = []

    def select(self, state, k):
        self.states.append(state)
        scores = np.arange(len(state.candidates), dtype=np.float64)
        return Selection(choose(scores, k, "lowest"), scores)


class PreparingSpy(Spy):
    def prepare(self, representation):
        self.prepared.append(representation.iteration)


@pytest.fixture
def scene(tmp_path):
    small_scene(tmp_path / "scene", count=16)
    return tmp_path / "scene"


@pytest.fixture
def timed(scene, tmp_path, monkeypatch):
    """Time a spy; return it and its record."""

    def run(spy=None, views_per_step=1, oracle=False, **runtime):
        spy = spy or Spy()
        method = Method("Spy", "2D-based", "A test.", "lowest", lambda settings, resources: spy, oracle=oracle)
        monkeypatch.setattr(registry, "methods", lambda: {"spy": Registered(method, "spy")})
        shared = SHARED | {"runtime": RuntimeSettings(**({"views": 5, "repeats": 2} | runtime))}
        write_state(scene, StateSettings(**shared), tmp_path / "state.safetensors")
        settings = TimingSettings(**shared, method="spy", selector={}, views_per_step=views_per_step)
        time_method(scene, tmp_path / "state.safetensors", settings, None, tmp_path / "spy.json", print)
        return spy, read_record(tmp_path / "spy.json", Runtime)

    return run


def test_each_timed_selection_follows_one_without_the_newest_photographs(timed, scene):
    from avs.scene.scene import read_scene

    spy, record = timed()
    assert [(len(state.captured), state.step) for state in spy.states] == [(4, 1), (5, 2)] * 2
    assert len(record.selections) == 2
    whole = read_scene(scene)
    pool = whole.pool
    captured = pool[initial_views(whole.cameras[pool].centers, 5)]
    np.testing.assert_array_equal(spy.states[1].captured.cameras.centers, whole.cameras[captured].centers)
    for state in spy.states:
        assert len(state.candidates) == record.candidates == len(pool) - 5
        assert state.truth is None
    draws = [state.rng.random() for state in spy.states]
    assert len(set(draws)) == 4


def test_a_batch_has_as_many_new_photographs(timed):
    spy, record = timed(views_per_step=2)
    assert [(len(state.captured), state.step) for state in spy.states] == [(3, 0), (5, 1)] * 2
    assert record.chosen == 2


def test_the_reconstruction_follows_the_schedule_up_to_the_selection(timed):
    _, record = timed()
    # Three views at iteration 2, four at 3, five at 4.
    assert (record.iteration, record.captured, record.own_fit) == (4, 5, False)


def test_more_views_than_an_episode_has_are_the_last_selection_of_one(timed):
    # Half of the pool of 14 is 7, and the last selection of such an episode has 6.
    _, record = timed(views=100)
    assert (record.captured, record.iteration) == (6, 6)


def test_a_method_that_prepares_the_reconstruction_has_a_fit_of_its_own(timed):
    spy, record = timed(spy=PreparingSpy())
    assert spy.prepared == [0]
    assert record.own_fit
    assert record.iteration == spy.states[0].representation.inner.iteration == 4


def test_oracles_are_shown_the_hidden_photographs(timed):
    spy, record = timed(oracle=True)
    assert len(spy.states[0].truth.candidates) == record.candidates
    assert len(spy.states[0].truth.test) == 2


def test_a_slow_method_is_timed_once(timed):
    _, record = timed(repeats=9, seconds=1e-9)
    assert len(record.selections) == 1


def test_a_checkpoint_of_other_settings_is_refused(timed, scene, tmp_path):
    timed()
    other = SHARED | {"representation": REPRESENTATION.model_copy(update={"sh_degree": 1})}
    settings = TimingSettings(**other, runtime=RuntimeSettings(views=5), method="spy", selector={}, views_per_step=1)
    with pytest.raises(UserError, match=r"state.safetensors: was written with other settings"):
        time_method(scene, tmp_path / "state.safetensors", settings, None, tmp_path / "spy.json", print)


@pytest.mark.parametrize(
    ("device", "needs", "expected"),
    [
        ("cuda", ("fisher_diagonal",), "cpu"),
        ("cuda", ("fisher_probes",), "cuda"),
        ("cuda", ("blending_weights", "copy"), "cpu"),
        ("cuda", (), "cuda"),
        ("cpu", ("fisher_diagonal",), "cpu"),
    ],
)
def test_a_record_tells_where_a_method_computes(device, needs, expected):
    settings = TimingSettings(
        **(SHARED | {"device": device}), runtime=RuntimeSettings(), method="spy", selector={}, views_per_step=1
    )
    assert device_of(settings, needs) == expected
