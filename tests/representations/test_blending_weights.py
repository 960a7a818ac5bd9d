"""Blending weights of single Gaussians, against those of the slow twin: derivatives of pixels by colours."""

import numpy as np
import pytest
from tolerances import BLENDING_WEIGHTS

from avs.representations.capabilities import HasBlendingWeights
from tests.factories import ring
from tests.rasterizer.blending_twin import COUNT, splats, weights

CAMERA = ring(6, size=(21, 14))[0]


@pytest.mark.parametrize("limit", [0.0, 0.5, 0.8])
def test_sums_over_pixels_in_front(limit):
    representation = splats()
    assert isinstance(representation, HasBlendingWeights)
    image = np.random.default_rng(0).normal(size=(14, 21)).astype(np.float32)
    weight, before = weights(representation, CAMERA)
    blended = (weight > 0) & (before > limit)
    assert np.abs(before[weight > 0] - limit).min() > 1e-5, "a rounding would decide"
    sums, pixels = representation.front_weights(CAMERA, image, limit)
    np.testing.assert_array_equal(pixels, blended.sum(axis=0))
    expected = (weight * blended * image.reshape(-1, 1)).sum(axis=0)
    magnitude = (weight * blended * np.abs(image).reshape(-1, 1)).sum(axis=0)
    assert (np.abs(sums - expected) <= BLENDING_WEIGHTS * magnitude).all()
    assert 0 < np.count_nonzero(pixels) <= COUNT


def test_opaque_gaussians_hide_what_is_behind():
    representation = splats(opacity=6.0)
    weight, _ = weights(representation, CAMERA)
    sums, pixels = representation.front_weights(CAMERA, np.ones((14, 21), np.float32), 0.0)
    np.testing.assert_array_equal(pixels, (weight > 0).sum(axis=0))
    np.testing.assert_allclose(sums, weight.sum(axis=0), rtol=BLENDING_WEIGHTS, atol=1e-5)


def test_values_are_blended_as_colours():
    representation = splats()
    values = np.random.default_rng(1).normal(size=COUNT).astype(np.float32)
    image = representation.blended_values(CAMERA, values)
    weight, _ = weights(representation, CAMERA)
    assert image.dtype == np.float32
    np.testing.assert_allclose(image.reshape(-1), weight @ values, atol=BLENDING_WEIGHTS)
    np.testing.assert_array_equal(representation.centres, representation.parameters["means"].detach().numpy())
