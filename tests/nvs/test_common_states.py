"""Common states: every method scores the same bits, the truth is that of slow twins, one failure is one reason."""

import hashlib

import numpy as np
import pytest
from factories import small_scene

from avs.nvs import common_states
from avs.nvs.common_states import capture_order, moments_of, write_common_states
from avs.nvs.common_states_record import CommonStates
from avs.nvs.common_states_settings import CommonStatesJob, CommonStatesSettings, ScoredMethodSettings
from avs.nvs.experiment import builder
from avs.nvs.protocol import ProtocolSettings
from avs.nvs.schedule import initial_captures
from avs.representations.gaussians.gaussian_settings import Densification, GaussianSettings, InitialPoints
from avs.scene.scene import SceneFile
from avs.selection import registry
from avs.selection.contract import Method
from avs.selection.registry import Registered
from avs.selection.session import Session
from avs.system.errors import UserError
from avs.system.job_logs import fault_of
from avs.system.records import read_record, write_record
from avs.system.seeds import seed_of
from metrics.image import psnr, ssim

PROTOCOL = ProtocolSettings(initial_views=3, budget=8, pool_share=1, additions=(2, 4, 6, 9, 12), iterations=20)
REPRESENTATION = GaussianSettings(
    iterations=20, sh_degree=0, points=InitialPoints(choice="sfm"), densification=Densification(start=500)
)
STATES = CommonStatesSettings(views=(4, 6), gain_candidates=3, gain_passes=2)


class Spy:
    """Scores by number, and keeps a hash of the reconstruction and the names that it was shown."""

    def __init__(self, folder, own=False):
        self.folder = folder
        self.seen = []
        self.steps = []
        if own:
            self.prepare = lambda representation: None

    def score(self, state):
        path = self.folder / "seen.safetensors"
        self.steps.append(state.step)
        state.representation.save(path)
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        self.seen.append((digest, state.names, state.captured.names, state.truth))
        return np.arange(len(state.names), dtype=np.float64)


class Spoils(Spy):
    """Changes the reconstruction after it has looked at it."""

    def score(self, state):
        scores = super().score(state)
        state.representation.fit(state.captured, 3)
        return scores


@pytest.fixture
def scene(tmp_path):
    return small_scene(tmp_path / "scene", count=16)


@pytest.fixture
def run(scene, tmp_path, monkeypatch):
    """Run a job with selectors by identifier; return the record and its bytes."""

    def write(selectors, states=STATES, protocol=PROTOCOL, seed=0, together=1, **metadata):
        found = {
            name: Registered(
                Method(name, "2D-based", "A test.", "lowest", lambda *_, made=made: made, **metadata), name
            )
            for name, made in selectors.items()
        }
        monkeypatch.setattr(registry, "methods", lambda: found)
        settings = job(selectors, states, protocol, together)
        out = tmp_path / "record.json"
        write_common_states(scene.folder, settings, seed, {}, out, lambda line: None)
        return read_record(out, CommonStates), out.read_bytes()

    return write


def job(methods, states=STATES, protocol=PROTOCOL, together=1):
    listed = tuple(ScoredMethodSettings(method=name, selector={}, views_together=together) for name in methods)
    return CommonStatesJob(
        device="cpu", protocol=protocol, representation=REPRESENTATION, common_states=states, methods=listed
    )


def test_every_method_is_shown_the_same_bits_even_after_one_that_changes_them(run, tmp_path):
    selectors = {"first": Spy(tmp_path), "spoils": Spoils(tmp_path), "last": Spy(tmp_path)}
    record, _ = run(selectors)
    expected = [(state.reconstruction, tuple(state.candidates)) for state in record.states]
    for selector in selectors.values():
        assert [seen[:2] for seen in selector.seen] == expected
        assert [len(captured) for _, _, captured, _ in selector.seen] == [4, 6]
        assert all(truth is None for _, _, _, truth in selector.seen)
    assert len(set(expected)) == 2
    assert all(scored.scores[0] == list(range(len(record.states[0].candidates))) for scored in record.methods)
    assert not any(scored.own_fit for scored in record.methods)


@pytest.mark.parametrize(("together", "steps"), [(1, [1, 3]), (2, [0, 1])])
def test_a_method_is_told_the_number_that_the_selection_has_in_its_episodes(run, tmp_path, together, steps):
    selectors = {"plain": Spy(tmp_path), "own": Spy(tmp_path, own=True)}
    run(selectors, together=together)
    assert selectors["plain"].steps == selectors["own"].steps == steps


def test_a_method_that_prepares_the_reconstruction_scores_a_twin_of_as_many_steps(run, tmp_path):
    selectors = {"plain": Spy(tmp_path), "own": Spy(tmp_path, own=True)}
    record, _ = run(selectors)
    assert [scored.own_fit for scored in record.methods] == [False, True]
    # This one prepares nothing, so that its twin has the very bits of the common reconstruction.
    assert selectors["own"].seen == selectors["plain"].seen


def test_one_failure_leaves_the_others_as_they_are(run, tmp_path, capsys):
    class Fails:
        def __init__(self, error):
            self.calls = 0
            self.error = error

        def score(self, state):
            self.calls += 1
            if self.calls == 2:
                raise self.error
            return np.zeros(len(state.names))

    class Broken:
        def score(self, state):
            return np.zeros(1)

    selectors = {
        "raises": Fails(RuntimeError("no luck")),
        "tells": Fails(UserError("weights", "damaged", "fetch them")),
        "exits": Fails(SystemExit(3)),
        "broken": Broken(),
        "sound": Spy(tmp_path),
    }
    record, _ = run(selectors)
    failures = {scored.method: scored.failure for scored in record.methods}
    assert failures == {
        "raises": "RuntimeError: no luck",
        "tells": "weights: damaged; fetch them",
        "exits": "SystemExit: 3",
        "broken": "ValueError: broken returned scores that are not 10 finite numbers",  # a pool of 14 less 4 views
        "sound": None,
    }
    # The traceback is there, and is not what a killed job would be thought to have ended with.
    printed = capsys.readouterr().out
    (tmp_path / "job.log").write_text(printed)
    assert "| RuntimeError: no luck" in printed
    assert fault_of(tmp_path / "job.log") is None
    scores = {scored.method: scored.scores for scored in record.methods}
    assert scores["raises"][0] is not None
    assert scores["raises"][1] is None
    assert scores["broken"] == [None, None]
    assert None not in scores["sound"]


def test_the_same_settings_and_seed_give_the_same_bytes(run, tmp_path):
    first, again = (run({"spy": Spy(tmp_path)})[1] for _ in range(2))
    assert first == again
    assert run({"spy": Spy(tmp_path)}, seed=1)[1] != first


def test_the_truth_of_a_state_does_not_depend_on_the_methods(run, tmp_path):
    alone, _ = run({"one": Spy(tmp_path)})
    beside, _ = run({"spoils": Spoils(tmp_path), "one": Spy(tmp_path)})
    assert beside.states == alone.states


def test_the_truth_is_that_of_slow_twins(run, scene, tmp_path):
    record, _ = run({"spy": Spy(tmp_path)})
    order = [scene.names.index(name) for name in record.captured]
    session = Session(scene, builder(scene, REPRESENTATION, 0, "cpu"), np.array(order[:3]))
    session.fit_until(2)
    session.capture(np.array(order[3:4]))
    session.fit_until(4)
    state = record.states[0]
    assert (state.views, state.iteration) == (4, 4)
    for name, value, similarity in zip(state.candidates, state.psnr, state.ssim, strict=True):
        row = scene.names.index(name)
        image = session.representation.render(scene.cameras[[row]]).rgb[0]
        photograph = scene.views(np.array([row])).images[0]
        assert psnr(image, photograph) == value
        assert ssim(image, photograph) == similarity
    test = scene.views(scene.test)

    def quality(views, seed):
        fitted = session.representation.copy(seed)
        fitted.fit(views, 2 * 5)
        return np.mean([psnr(fitted.render(test.cameras[[row]]).rgb[0], test.images[row]) for row in range(len(test))])

    for number, measured in enumerate(state.gains):
        seed = seed_of("gain", scene.name, 0, 4, number)
        without = quality(session.views, seed)
        assert sum(value is not None for value in measured) == 3
        for name, value in zip(state.candidates, measured, strict=True):
            if value is not None:
                row = scene.names.index(name)
                one = session.views.extended(scene.views(np.array([row])))
                assert value == pytest.approx(quality(one, seed) - without, abs=1e-9)
    assert [value is None for value in state.gains[0]] == [value is None for value in state.gains[1]]
    assert state.gains[0] != state.gains[1]


def test_without_copies_there_is_no_gain(run, tmp_path, monkeypatch):
    monkeypatch.setattr(common_states, "Copyable", type("NothingCopies", (), {}))
    record, _ = run({"spy": Spy(tmp_path)})
    assert all(state.gains is None and state.psnr for state in record.states)


@pytest.mark.parametrize(("wanted", "views"), [((1, 99), [3, 7]), ((4, 5, 6), [4, 5, 6]), ((100,), [7])])
def test_moments_are_selections_of_an_episode(scene, wanted, views):
    moments = moments_of(scene, job((), CommonStatesSettings(views=wanted)))
    assert [moment.views for moment in moments] == views
    assert all(PROTOCOL.additions[moment.views - 3] == moment.iteration for moment in moments)


def test_steps_of_several_views_have_the_moments_that_they_pass(scene):
    protocol = PROTOCOL.model_copy(update={"views_per_step": 2})
    moments = moments_of(scene, job((), CommonStatesSettings(views=(4, 6, 7)), protocol))
    assert [(moment.views, moment.iteration) for moment in moments] == [(3, 2), (5, 4), (7, 6)]


def test_a_reconstruction_that_begins_again_after_each_view_does_so_here(run, tmp_path):
    protocol = PROTOCOL.model_copy(update={"refit": "reinit"})
    selectors = {"plain": Spy(tmp_path), "own": Spy(tmp_path, own=True)}
    record, _ = run(selectors, protocol=protocol)
    assert selectors["own"].seen == selectors["plain"].seen
    assert [state.views for state in record.states] == [4, 6]


def test_orders_begin_with_the_initial_views_and_go_through_the_pool(scene):
    initial = initial_captures(scene, PROTOCOL).tolist()
    orders = {}
    for name in ("random", "farthest"):
        settings = job((), CommonStatesSettings(order=name))
        orders[name] = [capture_order(scene, settings, seed).tolist() for seed in (0, 1)]
        for order in orders[name]:
            assert order[:3] == initial
            assert sorted(order) == scene.pool.tolist()
    assert orders["random"][0] != orders["random"][1]
    assert orders["farthest"][0] == orders["farthest"][1]


def test_an_oracle_that_measures_nothing_of_the_table_is_shown_the_photographs(run, tmp_path):
    spy = Spy(tmp_path)
    run({"oracle": spy}, oracle=True)
    assert all(len(truth.candidates) == len(names) for _, names, _, truth in spy.seen)


def test_notes_of_the_scene_and_of_a_capped_budget_are_recorded(scene, tmp_path):
    scene_file = scene.folder / "scene.json"
    told = read_record(scene_file, SceneFile).model_copy(update={"notes": ["two images left out"]})
    write_record(scene_file, told.hashed())
    protocol = PROTOCOL.model_copy(update={"pool_share": 0.4})
    settings = job((), STATES, protocol)
    write_common_states(scene.folder, settings, 0, {}, tmp_path / "record.json", lambda line: None)
    record = read_record(tmp_path / "record.json", CommonStates)
    assert record.notes == [
        "toy: budget 5 instead of 8, because its pool has 14 views",
        "toy: two images left out",
    ]
    assert [state.views for state in record.states] == [4]
