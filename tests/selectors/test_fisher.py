"""FisherRF's score and selection, against its formula written out."""

import numpy as np
import pytest
from factories import MeanColor, ring

from avs.errors import UserError
from avs.selectors.base import Resources, State
from avs.selectors.fisher import FisherSelector, FisherSettings, information_gain
from avs.views import Views

CAMERAS = ring(9)


class Informed:
    """Has Fisher information drawn at random, one matrix per camera of the ring."""

    def __init__(self, seed=0):
        self.table = np.random.default_rng(seed).random((9, 5, 4)).astype(np.float32)
        self.table[:, 3] = 0  # a primitive that no camera sees

    def render(self, cameras):
        raise AssertionError("FisherRF needs no rendering")

    def fisher_diagonal(self, cameras, chain):
        assert chain == "once"
        for center in cameras.centers:
            yield self.table[np.argmin(np.linalg.norm(CAMERAS.centers - center, axis=1))]


def select(representation, k=1, **settings):
    images = tuple(np.zeros((16, 24, 3), np.uint8) for _ in range(3))
    state = State(representation, Views(CAMERAS[:3], images), CAMERAS[3:], np.random.default_rng(0), 0)
    return FisherSelector(FisherSettings(**settings), Resources()).select(state, k)


@pytest.mark.parametrize("regularisation", [1e-6, 2.0])
def test_the_score_is_the_sum_of_ratios(regularisation):
    representation = Informed()
    selection = select(representation, k=2, regularisation=regularisation)
    captured = representation.table[:3].astype(np.float64).sum(axis=0)
    expected = [
        sum(representation.table[c, g, p] / (captured[g, p] + regularisation) for g in range(5) for p in range(4))
        for c in range(3, 9)
    ]
    np.testing.assert_allclose(selection.scores, expected, rtol=1e-6)
    assert selection.indices.tolist() == np.argsort(-np.array(expected))[:2].tolist()


def test_a_primitive_that_no_captured_view_sees_dominates():
    candidate = np.array([[1e-3], [1.0]], dtype=np.float32)
    captured = np.array([[0.0], [1.0]])
    assert information_gain(candidate, captured, 1e-6) == pytest.approx(1e-3 / 1e-6 + 1.0, rel=1e-5)


def test_a_representation_without_fisher_information_is_a_clear_error():
    with pytest.raises(UserError, match="fisherrf: needs the capability HasFisherDiagonal, which MeanColor lacks"):
        select(MeanColor())
