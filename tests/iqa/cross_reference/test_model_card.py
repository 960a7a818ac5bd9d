import numpy as np
import pytest

from avs.iqa.cross_reference.model_card import Prediction, agreement


def _prediction(moment, predicted, true, captured=False, scene=0):
    pixels = np.array([[predicted, true], [predicted / 2, true / 2]], dtype=np.float32)
    return Prediction(scene, moment, captured, predicted, true, pixels)


def test_candidates_are_compared_within_their_moment():
    # the order of quality is wrong within each moment, though later moments are better and predicted so
    predictions = [
        _prediction(moment, predicted=moment + 0.1 * i, true=moment - 0.1 * i) for moment in range(3) for i in range(4)
    ]
    found = agreement(predictions)
    assert found["pearson"] > 0.9
    assert found["spearman"] > 0.6
    assert found["candidate_spearman"] == pytest.approx(-1)
    assert found["images"] == 12


def test_captured_views_are_no_candidates():
    predictions = [_prediction(0, i, i) for i in range(3)] + [_prediction(0, 9 - i, i, captured=True) for i in range(3)]
    assert agreement(predictions)["candidate_spearman"] == pytest.approx(1)


def test_correlation_with_a_constant_is_undefined():
    found = agreement([_prediction(0, 0.5, i) for i in range(4)])
    assert found["pearson"] is None
    assert found["candidate_spearman"] is None
    assert found["mean_absolute_error"] == pytest.approx(1.25)
