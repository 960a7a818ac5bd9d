"""Which photographs a rendering is compared with, and the sums that make the agreement of maps."""

import numpy as np
import pytest

from avs.iqa.cross_reference.trained_scorer import CrossReferenceScorer
from avs.iqa.held_out.held_out_settings import ReferencesVariant
from avs.iqa.held_out.reference_variants import Predicted, chosen_images, predict_variants
from avs.iqa.resizing import ResizeSettings
from tests import tolerances


def chosen(toys, row, **variant):
    return chosen_images(*toys, row, ReferencesVariant(**variant), np.random.default_rng(0))


@pytest.mark.parametrize("row", range(24))
def test_references_are_captured_at_the_moment_and_never_the_own_photograph(toys, row):
    data = toys[0]
    allowed = set(data.moments[data.moment_of[row]].captured) - {data.images[row]}
    for choice in ("random", "nearest"):
        found = chosen(toys, row, count=5, choice=choice)
        assert set(found) <= allowed
        assert len(set(found)) == len(found) == min(5, len(allowed))


def test_nearest_are_the_nearest(toys):
    data, row = toys[0], 23
    pool = [image for image in data.moments[2].captured if image != data.images[row]]
    expected = sorted(pool, key=lambda image: np.linalg.norm(data.centers[image] - data.centers[data.images[row]]))
    assert chosen(toys, row, count=2, choice="nearest") == expected[:2]


def test_predictions_are_those_of_the_scorer_with_the_same_references(toys, network):
    data = toys[0]
    scorer = CrossReferenceScorer(network, ResizeSettings(pixels=56), batch=5)
    variants = {
        "none": ReferencesVariant(count=0),
        "nearest": ReferencesVariant(count=1, choice="nearest"),
        "wrong": ReferencesVariant(count=8, choice="wrong"),
    }
    found = predict_variants(scorer, data, toys[1], variants)
    black = scorer.encode(np.zeros_like(data.photographs[0])[None])
    others = [scorer.encode(image[None])[0] for image in toys[1].photographs]
    for row in (0, 13, 23):
        rendering = data.renderings[row][None]
        nearest = [data.photographs[image] for image in chosen(toys, row, count=1, choice="nearest")]
        for name, references in (("none", black), ("nearest", scorer.encode(nearest[0][None])), ("wrong", others)):
            expected = scorer.score(rendering, [references])[0]
            assert found[name].scores[row] == pytest.approx(expected, rel=tolerances.SAME_IMAGE_IN_A_BATCH)


def test_black_images_take_the_place_of_photographs_that_are_too_few(toys, network):
    scorer = CrossReferenceScorer(network, ResizeSettings(pixels=56), batch=8)
    variants = {"five": ReferencesVariant(count=5), "none": ReferencesVariant(count=0)}
    padded, plain = (predict_variants(scorer, *toys, variants, pad) for pad in (True, False))
    np.testing.assert_array_equal(padded["none"].scores, plain["none"].scores)
    few = np.array(toys[0].moment_of) == 0  # three photographs are captured at the first moment
    assert (padded["five"].scores[few] != plain["five"].scores[few]).all()


def test_sums_give_error_and_correlation_of_all_pixels():
    rng = np.random.default_rng(0)
    maps = rng.random((3, 2, 6, 4)).astype(np.float32)
    found = Predicted(np.empty(3))
    for row, (predicted, true) in enumerate(maps):
        found.add(row, predicted, true)
    predicted, true = maps[:, 0].ravel(), maps[:, 1].ravel()
    assert found.pixel_error == pytest.approx(np.abs(predicted - true).mean(), rel=1e-6)
    assert found.pixel_pearson == pytest.approx(np.corrcoef(predicted, true)[0, 1], rel=1e-5)
    np.testing.assert_allclose(found.scores, maps[:, 0].mean(axis=(1, 2)), rtol=1e-6)


def test_a_constant_map_has_no_correlation():
    found = Predicted(np.empty(1))
    found.add(0, np.full((4, 4), 0.5, np.float32), np.eye(4, dtype=np.float32))
    assert found.pixel_pearson is None
