"""The loop: schedule, budget, record, contract."""

import dataclasses

import numpy as np
import pytest
from factories import MeanColor, small_scene

from avs.nvs.episode_settings import EpisodeSettings
from avs.nvs.evaluation import Evaluator
from avs.nvs.experiment import replay_episode, run_episode
from avs.nvs.loop import Identity, Plan, run
from avs.nvs.protocol import ProtocolSettings, protocol_of_method
from avs.nvs.record import Episode
from avs.nvs.schedule import capped_budget
from avs.representations.gaussians.gaussian_settings import GaussianSettings, InitialPoints
from avs.scene.sampling import initial_views
from avs.selection import registry
from avs.selection.contract import OWN_SCHEDULE, Batches, Method, Selection
from avs.system.errors import UserError
from avs.system.records import read_record

PROTOCOL = ProtocolSettings(initial_views=4, budget=7, additions=(10, 25, 45), iterations=100)

NOTHING_SEEN = (  # MeanColor shows one colour
    "toy: every rendering of the test cameras is of one colour, so that its metrics are those of nothing"
)


class Last:
    """Chooses the last k candidates; keeps the states that it saw."""

    def __init__(self):
        self.states = []

    def select(self, state, k):
        self.states.append(state)
        n = len(state.candidates)
        return Selection(np.arange(n - k, n)[::-1].copy(), np.arange(n, dtype=float))


def plan(scene, selector, protocol=PROTOCOL, build=None, lines=None, chooses="highest"):
    identity = Identity("last", 0, {}, {})
    method = Method("Last", "2D-based", "A test.", chooses, lambda settings, resources: selector)
    build = build or (lambda captured: MeanColor())
    evaluate = Evaluator(scene, protocol.lpips)
    progress = (lines if lines is not None else []).append
    return Plan(scene, protocol, identity, method, selector, build, evaluate, progress)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene(tmp_path_factory.mktemp("episode") / "toy")


def test_views_are_added_at_the_scheduled_iterations(scene):
    episode, meta, representation, _ = run(plan(scene, Last()))
    assert [step.iteration for step in episode.steps] == [10, 25, 45]
    assert [point.iteration for point in episode.curve] == [10, 25, 45, 100]
    assert [point.views for point in episode.curve] == [4, 5, 6, 7]
    assert representation.fits == [(4, 10), (5, 15), (6, 20), (7, 55)]
    assert len(meta.steps) == 3
    assert meta.peak_memory_bytes > 0


def test_the_record_has_the_notes_of_the_scene(scene):
    noted = dataclasses.replace(scene, notes=("all images are undistorted",))
    assert run(plan(noted, Last()))[0].notes == ["toy: all images are undistorted", NOTHING_SEEN]


def test_captured_views_leave_the_candidates_and_test_views_never_enter(scene):
    episode, _, _, _ = run(plan(scene, Last()))
    test = {scene.names[i] for i in scene.test}
    pool = len(scene.names) - len(test)
    for number, step in enumerate(episode.steps):
        assert len(step.candidates) == len(step.scores) == pool - 4 - number
        assert not test & set(step.candidates)
        assert set(step.chosen) <= set(step.candidates)
        assert not set(step.candidates) & {*episode.initial, *episode.selected[:number]}
    assert episode.selected == [name for step in episode.steps for name in step.chosen]
    assert len(set(episode.initial + episode.selected)) == 7


def test_the_initial_views_are_farthest_view_sampled_from_the_first_of_the_pool(scene):
    episode, _, _, _ = run(plan(scene, Last()))
    pool = scene.pool
    expected = pool[initial_views(scene.cameras[pool].centers, 4)]
    assert episode.initial == [scene.names[i] for i in expected]
    assert episode.initial[0] == scene.names[pool[0]]


def test_the_selector_sees_the_images_captured_so_far(scene):
    selector = Last()
    run(plan(scene, selector))
    assert [len(state.captured) for state in selector.states] == [4, 5, 6]
    assert [state.step for state in selector.states] == [0, 1, 2]
    draws = [state.rng.random() for state in selector.states]
    assert len(set(draws)) == 3


def test_a_batch_fills_the_budget_exactly(scene):
    protocol = PROTOCOL.model_copy(update={"views_per_step": 2})
    episode, _, _, _ = run(plan(scene, Last(), protocol))
    assert [len(step.chosen) for step in episode.steps] == [2, 1]
    assert [point.views for point in episode.curve] == [4, 6, 7]


def test_views_chosen_together_wait_and_are_captured_when_those_of_other_methods_are(scene):
    common = ProtocolSettings(initial_views=4, budget=9, additions=(10, 20, 30, 40, 50), iterations=100)
    joint, selector = common.model_copy(update={"views_per_choice": 4}), Last()
    lines = []
    episode, meta, representation, _ = run(plan(scene, selector, joint, lines=lines))
    single, _, other, _ = run(plan(scene, Last(), common))
    # Five views are no multiple of four: the second choice is of one.
    assert [len(step.chosen) for step in episode.steps] == [4, 1]
    assert [step.iteration for step in episode.steps] == [10, 50]
    assert [step.captured for step in episode.steps] == [[10, 20, 30, 40], [50]]
    assert [step.captured for step in single.steps] == [[10], [20], [30], [40], [50]]
    assert [(point.iteration, point.views) for point in episode.curve] == [
        (point.iteration, point.views) for point in single.curve
    ]
    assert representation.fits == other.fits
    assert episode.selected == [name for step in episode.steps for name in step.chosen]
    assert [(state.step, len(state.captured)) for state in selector.states] == [(0, 4), (1, 8)]
    assert len(meta.steps) == 2
    assert [line.split(",")[0] for line in lines] == ["step 1 of 2", "step 2 of 2", "end"]


def test_a_capped_budget_ends_a_joint_choice_early(tmp_path):
    small = small_scene(tmp_path / "small", count=16)  # a pool of 14, of which half are captured
    protocol = ProtocolSettings(initial_views=4, additions=tuple(range(1, 17)), iterations=20, views_per_choice=2)
    episode, _, _, _ = run(plan(small, Last(), protocol))
    assert [step.captured for step in episode.steps] == [[1, 2], [3]]
    assert len(episode.initial + episode.selected) == episode.budget == 7


def test_a_joint_choice_that_waits_survives_a_restart_of_the_reconstruction(scene):
    protocol = PROTOCOL.model_copy(update={"views_per_choice": 3, "refit": "reinit"})
    episode, _, representation, _ = run(plan(scene, Last(), protocol))
    assert [step.captured for step in episode.steps] == [[10, 25, 45]]
    assert representation.fits == [(7, 55)]


def test_every_method_that_is_ranked_has_equally_many_views_at_every_iteration():
    common = ProtocolSettings()
    for identifier, registered in registry.methods().items():
        method = registered.method
        own = protocol_of_method(common, method.batches, {})
        schedule = (own.additions, own.views_per_step, own.iterations, own.budget)
        same = schedule == (common.additions, common.views_per_step, common.iterations, common.budget)
        assert same == (method.group != OWN_SCHEDULE), identifier
    assert protocol_of_method(common, registry.find("fisherrf4").method.batches, {}).views_together == 4


def test_a_replay_of_joint_choices_has_the_same_curve(scene, tmp_path):
    points = InitialPoints(random_count=60)
    settings = EpisodeSettings(
        method="farthest",
        device="cpu",
        protocol=PROTOCOL.model_copy(update={"views_per_choice": 2}),
        representation=GaussianSettings(iterations=100, sh_degree=0, points=points),
        selector={},
    )
    run_episode(scene.folder, settings, 0, None, tmp_path / "first", lambda line: None)
    replay_episode(scene.folder, tmp_path / "first" / "episode.json", "cpu", tmp_path / "second", lambda line: None)
    first, second = (read_record(tmp_path / name / "episode.json", Episode) for name in ("first", "second"))
    assert [step.captured for step in second.steps] == [[10, 25], [45]]
    assert [(step.chosen, step.captured) for step in second.steps] == [
        (step.chosen, step.captured) for step in first.steps
    ]
    assert second.curve == first.curve


def test_refit_from_scratch_builds_a_new_representation_on_the_captured_views(scene):
    built = []

    def build(captured):
        built.append(len(captured))
        return MeanColor()

    protocol = PROTOCOL.model_copy(update={"refit": "reinit"})
    _, _, representation, _ = run(plan(scene, Last(), protocol, build))
    assert built == [4, 5, 6, 7]
    assert representation.fits == [(7, 55)]


def test_one_line_a_step_is_reported(scene):
    lines = []
    run(plan(scene, Last(), lines=lines))
    assert len(lines) == 4
    assert lines[0].startswith("step 1 of 3, view ")
    assert "PSNR" in lines[0]


def test_notes_of_the_method_are_recorded(scene):
    selector = Last()
    selector.notes = ("fitted anew",)
    episode, _, _, _ = run(plan(scene, selector))
    assert episode.notes == ["Last: fitted anew", NOTHING_SEEN]


def test_the_record_is_the_same_for_the_same_seed(scene):
    first, _, _, _ = run(plan(scene, Last()))
    second, _, _, _ = run(plan(scene, Last()))
    assert first.model_dump_json() == second.model_dump_json()


@pytest.mark.parametrize(
    ("selection", "fault"),
    [
        (Selection(np.array([0, 1]), np.zeros(31)), "indices"),
        (Selection(np.array([99]), np.zeros(31)), "indices"),
        (Selection(np.array([0]), np.zeros(3)), "scores"),
        (Selection(np.array([0]), np.full(31, np.nan)), "scores"),
        (Selection(np.array([4]), np.ones(31), np.arange(31) < 4), "did not score"),
        (Selection(np.array([1]), np.ones(31)), "first, whose score is 1: the highest is 1, of candidate 0"),
    ],
)
def test_a_broken_selection_is_refused(scene, selection, fault):
    class Broken:
        def select(self, state, k):
            return selection

    with pytest.raises(ValueError, match=fault):
        run(plan(scene, Broken()))


@pytest.mark.parametrize("scores", [np.zeros(3), np.full(31, np.nan), np.zeros((31, 1))])
def test_broken_scores_are_refused(scene, scores):
    class Broken:
        def score(self, state):
            return scores

    with pytest.raises(ValueError, match="Last returned scores that are not 31 finite numbers"):
        run(plan(scene, Broken()))


def test_notes_that_are_no_texts_are_refused(scene):
    """A text by itself would be taken letter by letter."""
    selector = Last()
    selector.notes = "abc"
    with pytest.raises(TypeError, match="Last has notes that are no tuple of texts: 'abc'"):
        run(plan(scene, selector))


def test_a_schedule_of_another_length_than_the_optimisation_is_told(scene):
    told = plan(scene, Last())
    told = dataclasses.replace(told, identity=dataclasses.replace(told.identity, representation={"iterations": 30}))
    note = "the schedule of the learning rates is for 30 iterations, and the optimisation ends at iteration 100"
    assert note in run(told)[0].notes
    assert note not in run(plan(scene, Last()))[0].notes


def test_a_choice_against_the_declared_direction_is_refused(scene):
    with pytest.raises(
        ValueError, match="Last chose candidate 30 first, whose score is 30: the lowest is 0, of candid"
    ):
        run(plan(scene, Last(), chooses="lowest"))


@pytest.mark.parametrize(("chooses", "place"), [("lowest", 0), ("highest", -1)])
def test_scores_are_enough_and_the_loop_takes_the_direction_from_the_metadata(scene, chooses, place):
    class Scores:
        def score(self, state):
            return np.arange(len(state.candidates))

    episode, _, _, _ = run(plan(scene, Scores(), chooses=chooses))
    assert [step.chosen for step in episode.steps] == [[step.candidates[place]] for step in episode.steps]
    assert episode.chooses == chooses


def test_rendering_is_timed_without_the_method(scene):
    class Renders:
        def score(self, state):
            return state.representation.render(state.candidates).rgb.mean(axis=(1, 2, 3))

    _, meta, _, _ = run(plan(scene, Renders()))
    assert all(0 < times.render_seconds < times.total_seconds for times in meta.steps)


def test_a_method_brings_its_batches_and_the_configuration_has_the_last_word():
    batches = Batches(views=4, additions=(1200, 3600, 7200, 12000))
    own = protocol_of_method(ProtocolSettings(), batches, {})
    assert (own.views_per_step, own.additions) == (4, (1200, 3600, 7200, 12000))
    common = ProtocolSettings(iterations=1500, additions=tuple(range(10, 170, 10)))
    assert protocol_of_method(common, batches, {}).additions == (60, 180, 360, 600)
    assert protocol_of_method(common, batches, {"additions": (5, 6, 7, 8)}).additions == (5, 6, 7, 8)
    assert protocol_of_method(common, None, {}) == common
    joint = protocol_of_method(common, Batches(views=4), {})
    assert joint == common.model_copy(update={"views_per_choice": 4})
    assert protocol_of_method(common, Batches(views=4), {"views_per_choice": 2}).views_together == 2


def test_a_small_pool_caps_the_budget_and_says_so():
    assert capped_budget(ProtocolSettings(), 40, "x") == (20, [])
    budget, notes = capped_budget(ProtocolSettings(), 17, "fern")
    assert budget == 8
    assert notes == ["fern: budget 8 instead of 20, because its pool has 17 views"]
    assert capped_budget(ProtocolSettings(), 5, "x")[0] == 5


def test_a_pool_without_a_candidate_is_refused():
    with pytest.raises(UserError, match="pool of 4 images leaves no candidate after 4 initial views; add images"):
        capped_budget(ProtocolSettings(), 4, "x")


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"additions": (10, 10, 45)}, "ascend"),
        ({"additions": (10, 25, 100)}, "before the last iteration"),
        ({"budget": 20}, "cannot fill"),
        ({"views_per_step": 2, "views_per_choice": 3}, "views_per_choice 3 is no multiple of views_per_step 2"),
    ],
)
def test_an_inconsistent_protocol_is_refused(change, fault):
    with pytest.raises(ValueError, match=fault):
        ProtocolSettings(**(PROTOCOL.model_dump() | change))


def test_the_papers_schedule_is_the_default():
    protocol = ProtocolSettings()
    gaps = np.diff((0, *protocol.additions))
    # FisherRF's v20seq1_inplace: the gap grows by 100 with each view.
    assert gaps.tolist() == [100 * n for n in range(4, 20)]
