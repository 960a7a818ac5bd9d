import dataclasses

import numpy as np
import pytest

from avs.iqa.cross_reference.model_card import Prediction, agreement, predict_held_out
from avs.iqa.cross_reference.scorer_settings import ReferenceSettings, ScorerSettings, TrainingSettings
from avs.iqa.cross_reference.trained_scorer import CrossReferenceScorer
from avs.iqa.resizing import ResizeSettings


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


@pytest.mark.parametrize(("pad", "count"), [("none", 1), ("black", 3)])
def test_references_are_filled_up_as_in_the_training(toys, network, pad, count):
    """A moment with two captured photographs leaves one for a rendering of either."""
    few = [moment.model_copy(update={"captured": moment.captured[:2]}) for moment in toys[0].moments]
    scene = dataclasses.replace(toys[0], moments=tuple(few))
    references = ReferenceSettings(count=3, pad=pad)
    training = TrainingSettings(resize=ResizeSettings(side="long", pixels=56), crop=28, references=references)
    settings = ScorerSettings(training=training)
    seen = []

    class Recorded(CrossReferenceScorer):
        def maps(self, images, references):
            seen.extend(map(len, references))
            return super().maps(images, references)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("avs.iqa.cross_reference.model_card.CrossReferenceScorer", Recorded)
        list(predict_held_out(network, settings, [scene], "cpu"))
    assert min(seen) == count
    assert set(seen) == ({1, 2} if pad == "none" else {3})
