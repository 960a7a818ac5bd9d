"""Oracles against plain loops: the worst rendering, and the greedy choice that helps the test images most."""

import numpy as np
import pytest
from factories import named_views, ring, selected, state_of

from avs.representations.base import Rendering
from avs.selection import registry
from avs.selection.contract import ORACLE, Resources, Truth
from avs.selectors.oracle import GainOracle, GainSettings
from metrics.image import psnr, ssim


class Painted:
    """Renders the mean colour of what it was fitted to, all views alike; it can be copied."""

    def __init__(self, level=0.5):
        self.level = level

    def fit(self, views, iterations):
        self.level = float(np.mean([image.mean() for image in views.images])) / 255

    def copy(self, seed=None):
        return Painted(self.level)

    def render(self, cameras):
        shape = (len(cameras), 16, 24)
        image = np.full((*shape, 3), self.level, dtype=np.float32)
        return Rendering(image, np.ones(shape, np.float32), np.ones(shape, np.float32))


def views(levels):
    cameras = ring(max(len(levels), 1))
    return named_views(cameras[: len(levels)], tuple(np.full((16, 24, 3), level, np.uint8) for level in levels))


def state(levels, captured=(100, 120), test=(40, 60), seed=0):
    candidates = views(levels)
    rng = np.random.default_rng(seed)
    return state_of(Painted(), views(captured), candidates.cameras, rng, 0, Truth(candidates, views(test)))


def create(identifier, **settings):
    method = registry.find(identifier).method
    assert method.oracle
    assert method.group == ORACLE
    return method.build(registry.create_settings(identifier, settings), Resources())


@pytest.mark.parametrize(("identifier", "metric"), [("oracle-ssim", ssim), ("oracle-psnr", psnr)])
def test_the_worst_true_rendering_is_chosen(identifier, metric):
    levels = [130, 10, 127, 250, 100, 250]
    selection = selected(identifier, create(identifier), state(levels), 3)
    rendered = np.full((16, 24, 3), 0.5, np.float32)
    expected = [metric(rendered, np.full((16, 24, 3), level, np.uint8)) for level in levels]
    assert selection.scores.tolist() == expected
    assert selection.indices.tolist() == sorted(range(6), key=lambda row: (expected[row], row))[:3]
    assert registry.find(identifier).method.chooses == "lowest"


def looped_greedy(levels, captured, test, k):
    """The candidate whose level moves the mean of all levels nearest to the test images; ties to the first."""
    chosen, gains = [], []
    for _ in range(k):
        rows = [row for row in range(len(levels)) if row not in chosen]
        have = [*captured, *(levels[row] for row in chosen)]

        def quality(used):
            mean = np.float32(np.mean(used) / 255)
            return np.mean([10 * np.log10(1 / (float(mean) - level / 255) ** 2) for level in test])

        found = {row: quality([*have, levels[row]]) - quality(have) for row in rows}
        gains = gains or [found[row] for row in range(len(levels))]
        chosen.append(max(rows, key=lambda row: found[row]))
    return chosen, gains


@pytest.mark.parametrize("k", [1, 3, 7])
def test_the_gain_is_followed_greedily(k):
    levels = [200, 15, 90, 0, 30, 90, 250]
    selection = selected("oracle-gain", create("oracle-gain"), state(levels), k)
    chosen, gains = looped_greedy(levels, (100, 120), (40, 60), k)
    np.testing.assert_allclose(selection.scores, gains, rtol=1e-6)
    assert selection.indices.tolist() == chosen
    assert selection.scored.all()


def test_equal_gains_go_to_the_lowest_index():
    assert selected("oracle-gain", create("oracle-gain"), state([9, 9, 9, 9]), 2).indices.tolist() == [0, 1]


def test_only_the_sample_is_tried_and_scored():
    levels = list(range(0, 250, 10))
    selection = selected("oracle-gain", create("oracle-gain", candidates=6), state(levels), 1)
    assert selection.scored.sum() == 6
    tried = np.flatnonzero(selection.scored)
    assert selection.indices[0] == tried[np.argmax(selection.scores[tried])]
    other = selected("oracle-gain", create("oracle-gain", candidates=6), state(levels, seed=1), 1)
    assert other.scored.tolist() != selection.scored.tolist()


def test_the_sample_is_large_enough_for_the_batch():
    selection = selected("oracle-gain", create("oracle-gain", candidates=2), state([10, 20, 30, 40, 50]), 4)
    assert selection.scored.sum() == 4


@pytest.mark.parametrize("identifier", ["oracle-ssim", "oracle-psnr", "oracle-gain"])
@pytest.mark.parametrize(("count", "k"), [(1, 1), (4, 4)])
def test_a_selection_follows_the_contract(identifier, count, k):
    levels = list(range(10, 10 + count))
    selected(identifier, create(identifier), state(levels), k)


def test_the_ssim_of_the_test_images_can_be_followed_instead():
    settings = GainSettings(metric="ssim", passes=1)
    levels = [200, 15, 90]
    selection = selected("oracle-gain", GainOracle(settings, Resources()), state(levels, test=(50,)), 1)
    image = np.full((16, 24, 3), 50, np.uint8)

    def similarity(used):
        return ssim(np.full((16, 24, 3), np.mean(used) / 255, np.float32), image)

    expected = [similarity([100, 120, level]) - similarity([100, 120]) for level in levels]
    np.testing.assert_allclose(selection.scores, expected, rtol=1e-5)
