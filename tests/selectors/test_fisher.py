"""FisherRF's and POp-GS's scores and greedy choices, against their formulas written out."""

import math

import numpy as np
import pytest
from factories import MeanColor, named_views, ring, selected, state_of
from tolerances import INFORMATION_SUMS

from avs.representations.capabilities import FisherInformation
from avs.selection.contract import Resources
from avs.selection.registry import create_settings, find
from avs.system.errors import UserError

CAMERAS = ring(12)
CAPTURED, CANDIDATES, PRIMITIVES, PARAMETERS = 3, 9, 7, 4


class Informed:
    """Has Fisher information drawn at random, one matrix per camera of the ring; candidates 4 and 8 have the same."""

    def __init__(self, seed=0):
        rng = np.random.default_rng(seed)
        self.table = (rng.random((12, PRIMITIVES, PARAMETERS)) ** 4).astype(np.float32)
        self.table[rng.random((12, PRIMITIVES)) < 0.3] = 0
        self.table[:CAPTURED, 3] = 0  # a primitive that no captured view sees
        self.table[CAPTURED + 8] = self.table[CAPTURED + 4]
        self.computed = []
        self.probes = []

    def render(self, cameras):
        raise AssertionError("Fisher information needs no rendering")

    def fisher_diagonal(self, cameras, chain, parameters):
        assert (chain, parameters[0]) == ("once", "means")
        for center in cameras.centers:
            row = int(np.argmin(np.linalg.norm(CAMERAS.centers - center, axis=1)))
            self.computed.append(row)
            rows = np.flatnonzero(self.table[row].any(axis=1))
            yield FisherInformation(rows, self.table[row][rows], PRIMITIVES)

    def fisher_probes(self, cameras, chain, parameters, probes, seeds):
        assert len(seeds) == len(cameras)
        self.probes += [(probes, seed) for seed in seeds]
        return self.fisher_diagonal(cameras, chain, parameters)


def select(representation, method="fisherrf", k=1, count=CANDIDATES, seed=0, **settings):
    images = tuple(np.zeros((16, 24, 3), np.uint8) for _ in range(CAPTURED))
    candidates = CAMERAS[CAPTURED : CAPTURED + count]
    state = state_of(
        representation, named_views(CAMERAS[:CAPTURED], images), candidates, np.random.default_rng(seed), 0
    )
    return selected(method, find(method).method.build(create_settings(method, settings), Resources()), state, k)


def term(criterion, candidate, captured, regularisation):
    if criterion == "trace":
        return candidate / (captured + regularisation)
    if criterion == "d":
        return math.log((captured + candidate + regularisation) / (captured + regularisation))
    return 1 / (captured + regularisation) - 1 / (captured + candidate + regularisation)


def expected(table, criterion, k, regularisation):
    """Return the greedy choice and the first scores, everything scored again in every round."""
    captured = table[:CAPTURED].astype(np.float64).sum(axis=0)
    left, chosen, first = list(range(CANDIDATES)), [], None
    while len(chosen) < k:
        scores = {
            c: math.fsum(
                term(criterion, float(table[CAPTURED + c, g, p]), captured[g, p], regularisation)
                for g in range(PRIMITIVES)
                for p in range(PARAMETERS)
            )
            for c in left
        }
        first = first or [scores[c] for c in range(CANDIDATES)]
        best = max(left, key=lambda c: (scores[c], -c))
        chosen.append(best)
        left.remove(best)
        captured = captured + table[CAPTURED + best].astype(np.float64)
    return chosen, first


METHODS = [
    ("fisherrf", {}, "trace"),
    ("fisherrf4", {}, "trace"),
    ("popgs", {}, "d"),
    ("popgs", {"criterion": "t"}, "t"),
]


@pytest.mark.parametrize(("method", "settings", "criterion"), METHODS)
@pytest.mark.parametrize("regularisation", [1e-3, 2.0])
@pytest.mark.parametrize("k", [1, 4, CANDIDATES])
def test_scores_and_greedy_choice(method, settings, criterion, regularisation, k):
    representation = Informed()
    selection = select(representation, method, k, regularisation=regularisation, **settings)
    chosen, scores = expected(representation.table, criterion, k, regularisation)
    # the twin's differences of fractions cancel at a small lambda, hence more room for it
    room = 1e-9 if criterion == "t" else INFORMATION_SUMS
    np.testing.assert_allclose(selection.scores, scores, rtol=room)
    assert selection.indices.tolist() == chosen


def test_the_greedy_choice_differs_from_the_best_scores():
    selection = select(Informed(), "fisherrf4", 4, regularisation=1e-3)
    assert selection.indices.tolist() != np.argsort(-selection.scores, kind="stable")[:4].tolist()


def test_of_two_equal_candidates_the_first_is_chosen_and_the_other_loses():
    representation = Informed()
    representation.table[[CAPTURED + 4, CAPTURED + 8]] *= 100
    selection = select(representation, k=2)
    assert selection.scores[4] == selection.scores[8] == selection.scores.max()
    assert selection.indices[0] == 4
    assert selection.indices[1] != 8


@pytest.mark.parametrize("method", ["fisherrf", "popgs"])
def test_the_default_lambda_makes_unseen_primitives_dominate(method):
    representation = Informed()
    representation.table[CAPTURED + 5] = 0
    representation.table[CAPTURED + 5, 3] = 0.5
    representation.table[CAPTURED : CAPTURED + 5, 3] = representation.table[CAPTURED + 6 :, 3] = 0
    assert select(representation, method).indices.tolist() == [5]


def test_what_is_not_kept_is_computed_again_with_the_same_choice():
    keeping, forgetting = Informed(), Informed()
    kept = select(keeping, k=4, regularisation=1e-3)
    again = select(forgetting, k=4, regularisation=1e-3, kept_mebibytes=0)
    np.testing.assert_array_equal(kept.indices, again.indices)
    assert keeping.computed == list(range(12))
    assert forgetting.computed[:12] == list(range(12))
    # three chosen views, and in three rounds fewer candidates than all that are left
    assert 3 < len(forgetting.computed) - 12 < 3 + 8 + 7 + 6


def test_probes_are_asked_for_with_one_seed_for_each_view():
    representation = Informed()
    selection = select(representation, estimator="probes", probes=2, captured_probes=5, k=2, kept_mebibytes=0)
    np.testing.assert_array_equal(selection.scores, select(Informed(), k=2).scores)
    counts, seeds = zip(*representation.probes, strict=True)
    assert counts[: CAPTURED + CANDIDATES] == (5,) * CAPTURED + (2,) * CANDIDATES
    assert len(set(seeds[: CAPTURED + CANDIDATES])) == CAPTURED + CANDIDATES
    for row, seed in zip(representation.computed[12:], seeds[12:], strict=True):
        assert seed == seeds[row], "a view that is computed again must be estimated by the same signs"


def test_one_candidate():
    assert select(Informed(), count=1).indices.tolist() == [0]


@pytest.mark.parametrize(("estimator", "name"), [("exact", "fisher_diagonal"), ("probes", "fisher_probes")])
@pytest.mark.parametrize("method", ["fisherrf", "fisherrf4", "popgs"])
def test_a_representation_without_fisher_information_is_a_clear_error(method, estimator, name):
    with pytest.raises(UserError, match=f"{method}: needs the capability {name}, which MeanColor lacks"):
        select(MeanColor(), method, estimator=estimator)
