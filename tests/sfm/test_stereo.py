"""Kernels of stereo: samples, plane sweep, semi-global matching, PatchMatch."""

import numpy as np
import pytest
from scipy import ndimage
from tolerances import BILINEAR_SAMPLE, INVERSE_ROOT, SWEEP_COST

from avs.rasterizer.kernels import kernel
from avs.rasterizer.simd_memory import load, store
from avs.rasterizer.simd_types import LANES
from avs.sfm.chess_board import MARGIN, NOWHERE, columns_apart, halves, whole
from avs.sfm.plane_sweep import NOISE, RADIUS, UNKNOWN, sweep
from avs.sfm.semi_global import EDGE_STEP, JUMP, STEP, smoothed, winners
from avs.sfm.stereo_vectors import BORDER, bordered, count_of, inverse_root, least_of, nearest, packed, sample


@kernel
def sampled(picture, start, width, x, y, out):
    for at in range(0, len(x), LANES):
        store(out, at, sample(picture, start, width, load(x, at), load(y, at)))


@kernel
def looked_up(values, start, width, x, y, out):
    for at in range(0, len(x), LANES):
        store(out, at, nearest(values, start, width, load(x, at), load(y, at)))


@kernel
def least(values):
    return least_of(load(values, 0))


@kernel
def rooted(values, out):
    for at in range(0, len(values), LANES):
        store(out, at, inverse_root(load(values, at)))


@kernel
def greater_than(values, limit):
    return count_of(load(values, 0) > limit)


def noise(shape, seed=0, sigma=1.0):
    texture = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=shape), sigma)
    return np.clip(128 + 60 * texture / texture.std(), 0, 255).astype(np.uint8)


def places(height, width, count=64):
    rng = np.random.default_rng(1)
    return rng.uniform(0, width - 1.01, count).astype(np.float32), rng.uniform(0, height - 1.01, count).astype(
        np.float32
    )


def test_samples_are_bilinear():
    grey = noise((9, 21))
    x, y = places(9, 21)
    x[:3], y[:3] = (0, 19.99, 7), (0, 7.99, 3)
    for before in (0, 5):  # pictures may lie behind others
        stored = np.concatenate([np.zeros(before, dtype=np.int32), packed(grey)])
        out = np.empty(64, dtype=np.float32)
        sampled(stored, before, 21 + 2 * BORDER, x + BORDER, y + BORDER, out)
        expected = ndimage.map_coordinates(grey.astype(np.float64), [y, x], order=1)
        np.testing.assert_allclose(out, expected, atol=BILINEAR_SAMPLE)


def test_around_a_picture_its_edge_repeats():
    grey = noise((9, 21))
    x, y = (np.repeat(np.float32(place), LANES) for place in (0.4, 3.7))
    out = np.empty(LANES, dtype=np.float32)
    sampled(packed(grey), 0, 21 + 2 * BORDER, x, y, out)
    assert (out == grey[0, 0]).all()


def test_the_nearest_value_is_looked_up():
    values = np.random.default_rng(0).normal(size=(9, 21)).astype(np.float32)
    x, y = places(9, 21)
    out = np.empty(64, dtype=np.float32)
    looked_up(bordered(values), 0, 21 + 2 * BORDER, x + BORDER, y + BORDER, out)
    np.testing.assert_array_equal(out, values[(y + 0.5).astype(int), (x + 0.5).astype(int)])


def test_the_least_of_sixteen_is_found_wherever_it_is():
    for place in range(LANES):
        values = np.arange(1, LANES + 1, dtype=np.float32)
        values[place] = -3
        assert least(values) == -3


def test_inverse_roots_are_near_the_true_ones():
    values = np.geomspace(1e-6, 1e9, 64).astype(np.float32)
    out = np.empty(64, dtype=np.float32)
    rooted(values, out)
    np.testing.assert_allclose(out, 1 / np.sqrt(values.astype(np.float64)), rtol=INVERSE_ROOT)


def test_truths_are_counted():
    assert [greater_than(np.arange(LANES, dtype=np.float32), limit) for limit in (-1.0, 3.0, 15.0)] == [16, 12, 0]


def shifted_pair(height, width, disparity):
    """Return a picture, the one of a camera to its right, and the map from pixels of the first to the second."""
    texture = noise((height, width + 40))
    return (
        texture[:, 40 - disparity :][:, :width],
        texture[:, 40 : 40 + width],
        np.float32([[1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0]]),
    )


def swept(left, right, maps, planes):
    sizes = np.array([[0, *(side + 2 * BORDER for side in right.shape)]], dtype=np.int64)
    costs = sweep(left, packed(right), sizes, maps, np.float32(planes), *left.shape)
    return costs[:, :, : left.shape[1]]


def test_costs_are_one_less_the_correlation_of_windows():
    left, right, maps = shifted_pair(24, 37, 5)
    costs = swept(left, right, maps, [5, 7])
    x, y = 20, 11
    for plane, cost in zip((5, 7), costs[:, y, x], strict=True):
        windows = [
            picture[y - RADIUS : y + RADIUS + 1, column - RADIUS : column + RADIUS + 1].astype(np.float64)
            for picture, column in ((left, x), (right, x - plane))
        ]
        a, b = (window - window.mean() for window in windows)
        correlation = (a * b).mean() / np.sqrt(((a**2).mean() + NOISE) * ((b**2).mean() + NOISE))
        # of one source the second best cost is that of a source that sees nothing
        assert cost == pytest.approx((min(1 - correlation, UNKNOWN) + UNKNOWN) / 2, abs=SWEEP_COST)


def test_the_plane_of_the_surface_costs_least():
    left, right, maps = shifted_pair(24, 37, 5)
    best = swept(left, right, maps, range(16)).argmin(axis=0)
    assert (best[:, 8:] == 5).mean() > 0.99


def test_what_no_source_sees_has_the_cost_of_no_correlation():
    left, right, maps = shifted_pair(24, 37, 5)
    costs = swept(left, right, maps, [30, 60])
    assert (costs[1] == UNKNOWN).all()
    assert (costs[0, :, :29] == UNKNOWN).all()


def path_costs(costs, grey):
    """Return the paths' costs from the left, by the formula of Hirschmueller."""
    height, width, planes = costs.shape
    total = np.zeros(costs.shape)
    for y in range(height):
        total[y, 0] = costs[y, 0]
        for x in range(1, width):
            jump = max(JUMP / (1 + abs(int(grey[y, x]) - int(grey[y, x - 1])) / EDGE_STEP), STEP)
            before = total[y, x - 1]
            for k in range(planes):
                steps = [before[other] + STEP for other in (k - 1, k + 1) if 0 <= other < planes]
                total[y, x, k] = costs[y, x, k] + min(before[k], *steps, before.min() + jump) - before.min()
    return total


def test_paths_are_those_of_the_formula():
    rng = np.random.default_rng(0)
    costs = rng.uniform(0, 2, (5, 7, 16)).astype(np.float32)
    grey = rng.integers(0, 256, (5, 7)).astype(np.uint8)
    views = [
        (lambda values: values, lambda values: values),
        (lambda values: values[:, ::-1], lambda values: values[:, ::-1]),
        (lambda values: values.swapaxes(0, 1), lambda values: values.swapaxes(0, 1)),
        (lambda values: values[::-1].swapaxes(0, 1), lambda values: values.swapaxes(0, 1)[::-1]),
    ]
    expected = sum(back(path_costs(turn(costs), turn(grey))) for turn, back in views)
    np.testing.assert_allclose(smoothed(costs, grey), expected, rtol=SWEEP_COST)


def test_winners_lie_between_planes():
    planes = np.arange(16)
    costs = np.float32([[(planes - 4.3) ** 2, (planes - 0.0) ** 2, np.abs(planes - 15.0)]])
    np.testing.assert_allclose(winners(costs), [[4.3, 0, 15]], atol=SWEEP_COST)


@pytest.mark.parametrize("shape", [(5, 7), (6, 33), (12, 64), (1, 1)])
def test_colours_are_sorted_and_put_back(shape):
    values = np.arange(np.prod(shape), dtype=np.float32).reshape(shape)
    sorted_ = halves(values, NOWHERE)
    np.testing.assert_array_equal(whole(sorted_, shape[1]), values)
    assert (sorted_ != NOWHERE).sum() == values.size
    assert (sorted_[:, [0, -1]] == NOWHERE).all()


def test_columns_are_kept_apart_with_their_edges():
    grey = noise((6, 9))
    apart = columns_apart(grey, 2)
    wide = np.pad(grey, ((2, 2), (2 * MARGIN, 100)), mode="edge")
    for odd in range(2):
        own = wide[:, odd::2][:, : apart.shape[2]]
        np.testing.assert_array_equal(apart[odd], own)
