"""ActiveNeRF's choice: the rule that it asks for, ties, batches, and whole episodes."""

import numpy as np
import pytest
from factories import MeanColor, named_views, ring, selected, small_scene, state_of

from avs.nvs.episode_settings import EpisodeSettings
from avs.nvs.evaluation import Evaluator
from avs.nvs.experiment import replay_episode, run_episode
from avs.nvs.loop import Identity, Plan, run
from avs.nvs.protocol import ProtocolSettings
from avs.nvs.record import Episode
from avs.representations.gaussians.gaussian_settings import GaussianSettings, InitialPoints
from avs.representations.gaussians.splats import build
from avs.representations.learned_variance import VarianceReduction
from avs.selection.contract import PreparesRepresentation, Resources
from avs.selection.registry import create_settings, find
from avs.selectors.activenerf import ActiveNerfSelector, ActiveNerfSettings
from avs.system.errors import UserError
from avs.system.records import read_record

CAMERAS = ring(9)


class Varied:
    """Removes as much variance at each camera of the ring as a table says."""

    def __init__(self, table):
        self.table = np.array(table, dtype=np.float64)
        self.rules = []

    def render(self, cameras):
        raise AssertionError("ActiveNeRF needs no rendering")

    def learn_variance(self, rule):
        raise AssertionError("only before the first step")

    def variance_reduction(self, cameras, rule):
        self.rules.append(rule)
        return np.array([self.table[np.argmin(np.linalg.norm(CAMERAS.centers - c, axis=1))] for c in cameras.centers])


def select(representation, k=1, candidates=CAMERAS[3:], **settings):
    images = tuple(np.zeros((16, 24, 3), np.uint8) for _ in range(3))
    state = state_of(representation, named_views(CAMERAS[:3], images), candidates, np.random.default_rng(0), 0)
    return selected("activenerf", ActiveNerfSelector(ActiveNerfSettings(**settings), Resources()), state, k)


def test_the_largest_reductions_are_chosen_and_ties_go_to_the_lowest_index():
    selection = select(Varied([9, 9, 9, 1, 4, 2, 4, 0, 3]), k=3)
    assert selection.indices.tolist() == [1, 3, 5]
    assert selection.scores.tolist() == [1, 4, 2, 4, 0, 3]


def test_one_candidate_and_all_of_them():
    assert select(Varied(range(9)), candidates=CAMERAS[8:]).indices.tolist() == [0]
    assert select(Varied(range(9)), k=6).indices.tolist() == [5, 4, 3, 2, 1, 0]


@pytest.mark.parametrize(
    ("settings", "rule"),
    [
        ({}, VarianceReduction(1e-4, weighted=True, saturated=False)),
        ({"form": "pull_request"}, VarianceReduction(1e-4, weighted=True, saturated=True)),
        ({"numerator": "one", "constant": 0.0}, VarianceReduction(0.0, weighted=False, saturated=False)),
    ],
)
def test_the_form_decides_the_rule(settings, rule):
    representation = Varied(range(9))
    select(representation, **settings)
    assert representation.rules == [rule]


def test_a_representation_without_the_capability_is_a_clear_error():
    selector = ActiveNerfSelector(ActiveNerfSettings(), Resources())
    assert isinstance(selector, PreparesRepresentation)
    with pytest.raises(UserError, match="activenerf: needs the capability learned_variance, which MeanColor lacks"):
        selector.prepare(MeanColor())
    with pytest.raises(UserError, match="needs the capability learned_variance, which MeanColor lacks"):
        select(MeanColor())


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene(tmp_path_factory.mktemp("activenerf") / "toy", count=16)


def episode(scene, values=None, refit="continue", views_per_step=1):
    protocol = ProtocolSettings(
        initial_views=3, budget=6, additions=(6, 12, 18), iterations=24, refit=refit, views_per_step=views_per_step
    )
    points = InitialPoints(random_count=200, opacity=0.9)
    settings = GaussianSettings(iterations=24, sh_degree=1, points=points)
    method = find("activenerf").method
    plan = Plan(
        scene=scene,
        protocol=protocol,
        identity=Identity("activenerf", 0, {}, {}),
        method=method,
        selector=method.build(create_settings("activenerf", values or {}), Resources()),
        build=lambda captured: build(scene, captured, settings, 0, "cpu"),
        evaluate=Evaluator(scene, protocol.lpips),
        progress=lambda line: None,
    )
    return run(plan)


@pytest.mark.parametrize("values", [{}, {"form": "pull_request"}, {"numerator": "one"}])
def test_an_episode_learns_variances_and_chooses_by_them(scene, values):
    record, _, representation, _ = episode(scene, values)
    assert len(record.selected) == 3
    # The pull request's weights alpha_i T_(i+1) of a pixel have squares that sum up to 0.0902 at most, where all
    # opacities are 0.382: at the first variance of 1 every pixel lies below the floor of 0.1, and nothing is learned.
    learns = values.get("form") != "pull_request"
    assert bool(representation.parameters["log_variances"].detach().any()) == learns
    for step in record.steps:
        scores = np.array(step.scores)
        assert (scores > 0).all()
        assert step.chosen == [step.candidates[int(np.argmax(scores))]]


def test_an_episode_is_the_same_for_the_same_seed(scene):
    assert episode(scene)[0].model_dump_json() == episode(scene)[0].model_dump_json()


def test_a_replay_learns_variances_too(scene, tmp_path):
    protocol = ProtocolSettings(initial_views=3, budget=5, additions=(6, 12), iterations=24)
    representation = GaussianSettings(points=InitialPoints(random_count=200, opacity=0.9))
    settings = EpisodeSettings(
        method="activenerf", device="cpu", protocol=protocol, representation=representation, selector={"floor": 0.01}
    )
    run_episode(scene.folder, settings, 0, None, tmp_path / "first", lambda line: None)
    replay_episode(scene.folder, tmp_path / "first" / "episode.json", "cpu", tmp_path / "second", lambda line: None)
    first, second = (read_record(tmp_path / name / "episode.json", Episode) for name in ("first", "second"))
    assert second.curve == first.curve
    assert second.selected == first.selected


def test_a_reconstruction_that_begins_again_learns_variances_again(scene):
    record, _, representation, _ = episode(scene, refit="reinit", views_per_step=2)
    assert [len(step.chosen) for step in record.steps] == [2, 1]
    assert representation.parameters["log_variances"].detach().any()
