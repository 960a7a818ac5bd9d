"""Random and farthest-view selection, and the registry that finds methods by name."""

import importlib
import re
from dataclasses import replace

import numpy as np
import pytest
from factories import MeanColor, OnlyRenders, named_views, ring, selected, state_of

from avs.scene.sampling import farthest_order, initial_views
from avs.selection import registry
from avs.selection.choice import choose
from avs.selection.contract import Resources, Selection
from avs.selectors.farthest import FarthestSelector
from avs.selectors.random import RandomSelector, RandomSettings
from avs.system.errors import UserError


def state(candidates, captured=4, seed=0, step=0):
    cameras = ring(candidates + captured)
    images = tuple(np.zeros((16, 24, 3), np.uint8) for _ in range(captured))
    views = named_views(cameras[:captured], images)
    rng = np.random.default_rng(seed)
    return state_of(OnlyRenders(MeanColor()), views, cameras[captured:], rng, step)


def random_selector(**settings):
    return RandomSelector(RandomSettings(**settings), Resources())


def brute_force_farthest(candidates, captured, k):
    """Greedy max-min by all pairwise distances, recomputed at every choice."""
    chosen, points = [], list(captured)
    for _ in range(k):
        best, best_distance = -1, -1.0
        for i, candidate in enumerate(candidates):
            distance = min(np.sqrt(((candidate - point) ** 2).sum()) for point in points)
            if i not in chosen and distance > best_distance:
                best, best_distance = i, distance
        chosen.append(best)
        points.append(candidates[best])
    return chosen


@pytest.mark.parametrize("seed", range(5))
def test_farthest_order_is_greedy_max_min(seed):
    rng = np.random.default_rng(seed)
    candidates, captured = rng.normal(size=(17, 3)), rng.normal(size=(3, 3))
    order, scores = farthest_order(candidates, captured, 17)
    assert order.tolist() == brute_force_farthest(candidates, captured, 17)
    nearest = np.linalg.norm(candidates[:, None] - captured[None], axis=2).min(axis=1)
    np.testing.assert_allclose(scores, nearest, rtol=1e-12)


def test_farthest_order_takes_each_duplicate_once():
    order, _ = farthest_order(np.zeros((4, 3)), np.zeros((1, 3)), 4)
    assert order.tolist() == [0, 1, 2, 3]


def test_initial_views_start_where_told():
    line = np.arange(9.0)[:, None] * [1, 0, 0]
    assert initial_views(line, 4).tolist() == [0, 8, 4, 2]
    assert initial_views(line, 1, start=5).tolist() == [5]
    assert initial_views(line, 2, start=5).tolist() == [5, 0]


@pytest.mark.parametrize(
    ("identifier", "build"), [("random", random_selector), ("farthest", lambda: FarthestSelector(None, Resources()))]
)
@pytest.mark.parametrize(("candidates", "k"), [(1, 1), (9, 1), (9, 4), (9, 9)])
def test_a_selection_follows_the_contract(identifier, build, candidates, k):
    selection = selected(identifier, build(), state(candidates), k)
    assert len(set(selection.indices.tolist())) == k
    assert selection.scores.shape == (candidates,)
    assert np.isfinite(selection.scores).all()


def test_random_choice_depends_on_the_generator_alone():
    first, again, other = (selected("random", random_selector(), state(20, seed=seed), 5).indices for seed in (3, 3, 4))
    assert first.tolist() == again.tolist() != other.tolist()


def test_random_choice_is_uniform():
    counts = np.zeros(5)
    for seed in range(2000):
        counts[selected("random", random_selector(), state(5, seed=seed), 1).indices[0]] += 1
    # Four standard deviations of a binomial count with n = 2000, p = 1/5.
    assert np.abs(counts - 400).max() < 4 * np.sqrt(2000 * 0.2 * 0.8)


def test_reshuffling_repeats_the_draws_of_the_first_step():
    quirk, plain = random_selector(reshuffle=True), random_selector()
    first, second = state(8, seed=1, step=0), state(8, seed=2, step=1)
    assert quirk.score(first).tolist() == quirk.score(second).tolist()
    assert plain.score(state(8, seed=1)).tolist() != plain.score(second).tolist()


def test_ties_go_to_the_lowest_index():
    scores = np.array([1.0, 3.0, 3.0, 0.0, 0.0])
    assert choose(scores, 3, "highest").tolist() == [1, 2, 0]
    assert choose(scores, 3, "lowest").tolist() == [3, 4, 0]


@pytest.mark.parametrize(("scores", "k"), [([1.0, np.nan], 1), ([1.0, np.inf], 1), ([1.0], 2), ([1.0], 0)])
def test_an_impossible_choice_is_refused(scores, k):
    with pytest.raises(ValueError, match=r"finite|cannot choose"):
        choose(np.array(scores), k, "highest")


def test_methods_are_found_by_name_with_their_module():
    found = registry.methods()
    assert {"random", "farthest", "fisherrf"} <= set(found)
    assert found["farthest"].module == "avs.selectors.farthest"


@pytest.mark.parametrize(
    ("identifier", "fault", "line"),
    [
        ("my_method", {}, "lower-case letters, digits and hyphens"),
        ("mine", {"chooses": "greatest"}, "chooses 'greatest'; choose lowest or highest"),
        ("mine", {"needs": ("fisher",)}, "needs 'fisher', which is no capability; did you mean"),
    ],
)
def test_a_method_that_no_run_could_use_is_left_out_by_name(identifier, fault, line, monkeypatch):
    module = importlib.import_module("avs.selectors.random")
    monkeypatch.setattr(module, "METHODS", {identifier: replace(module.METHODS["random"], **fault)})
    found, broken = registry._found.__wrapped__()
    assert broken.keys() == {"avs.selectors.random"}
    assert re.match(f"method '{identifier}' of avs.selectors.random: .*{line}", broken["avs.selectors.random"])
    assert "random" not in found
    assert "farthest" in found


def test_a_joint_choice_of_no_array_is_refused_by_name():
    class Listed:
        def select(self, state, k):
            return Selection(list(range(k)), np.zeros(len(state.candidates)))

    with pytest.raises(TypeError, match="Random returned indices of type list, not an array"):
        selected("random", Listed(), state(3), 2)


def test_an_unknown_method_lists_near_names():
    with pytest.raises(UserError, match=r"'fisherfr': unknown; did you mean fisherrf"):
        registry.find("fisherfr")


@pytest.mark.parametrize("values", [{"lambda": 1}, {"chain": "twice"}])
def test_an_unknown_or_unfit_setting_names_the_known_ones(values):
    with pytest.raises(UserError, match=r"selectors\.fisherrf\..*settings of this method: chain, regularisation"):
        registry.create_settings("fisherrf", values)


@pytest.mark.parametrize("scores", [[True, False, True], [1j, 2j, 3j], ["1", "2", "3"], [None, 1.0, 2.0]])
def test_scores_that_are_no_real_numbers_are_refused_by_name(scores):
    class Odd:
        def score(self, state):
            return np.array(scores)

    with pytest.raises(TypeError, match=r"Random returned scores of type .*, not real numbers") as caught:
        selected("random", Odd(), state(3), 1)
    assert caught.value.__notes__ == ["method Random"]


@pytest.mark.parametrize("indices", [[0.0, 1.2], [True, False]])
def test_indices_that_are_no_whole_numbers_are_refused_by_name(indices):
    class Odd:
        def select(self, state, k):
            return Selection(np.array(indices), None)

    with pytest.raises(TypeError, match=r"Random returned indices of type .*, not whole numbers"):
        selected("random", Odd(), state(3), 2)
