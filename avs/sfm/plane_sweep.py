"""Plane sweep (Collins 1996): how well each depth of a pixel fits the pictures beside it, for all pixels of a view.

For every plane parallel to the picture, the sources are warped onto the view by the homography of the plane, and
compared within square windows by zero-mean normalised cross-correlation. Of the sources the best two count for each
pixel, so that one in which something else stands before the surface does no harm (Kang et al. 2001).
"""

from __future__ import annotations

import numpy as np

from avs.rasterizer.kernels import Floats, Integers, Number, inline, kernel
from avs.rasterizer.simd import any_of, broadcast, maximum, minimum, square_root, where
from avs.rasterizer.simd_memory import load, store
from avs.rasterizer.simd_types import LANES
from avs.sfm.stereo_vectors import BORDER, EDGE, inverse_root, sample

RADIUS = 3
"""Of the windows: 7 x 7 pixels."""

NOISE = 4.0
"""Added to variances, grey values squared: what is flatter than noise correlates with nothing."""

UNKNOWN = 1.0
"""Cost of no correlation, and of a source that does not see the point; 0 is perfect correlation."""

MARGIN = LANES
"""Zeros at either end of a row, so that windows need no cases."""


@kernel
def sweep(
    grey: Integers, sources: Integers, sizes: Integers, maps: Floats, planes: Floats, height: int, width: int
) -> Floats:
    """Return the matching costs ``[planes, height, columns]`` in 0..2, columns being the width in whole vectors.

    Args:
        grey: picture of the view, ``[height, width]`` uint8.
        sources: packed pictures of s views, one after another.
        sizes: ``[s, 3]`` of each source: its start in ``sources``, and its height and width with the border.
        maps: ``[s, 12]`` float32 of each source: a matrix A by rows and a vector b, such that the pixel (x, y) of the
            view at inverse depth d appears at the pixel with homogeneous coordinates ``A (x, y, 1) + d b``; pixels
            count from the centre of the first one.
        planes: ``[planes]`` float32, inverse depths.
        height: of the view in pixels.
        width: likewise.
    """
    columns = -(-width // LANES) * LANES
    stride = columns + 2 * MARGIN
    own = np.zeros(height * stride, np.float32)
    for y in range(height):
        for x in range(width):
            own[y * stride + MARGIN + x] = grey[y, x]
    numbers = np.arange(columns).astype(np.float32)
    counts = _counts(width, columns)
    means, weights = np.zeros(height * columns, np.float32), np.zeros(height * columns, np.float32)
    _own_moments(own, counts, height, columns, means, weights)
    first, second = np.empty(height * columns, np.float32), np.empty(height * columns, np.float32)
    warped, seen = np.zeros(height * stride, np.float32), np.zeros(height * columns, np.float32)
    costs = np.empty((len(planes), height * columns), np.float32)
    for k in range(len(planes)):
        first[:], second[:] = UNKNOWN, UNKNOWN
        for s in range(len(sizes)):
            start, rows, wide = sizes[s]
            _warp(sources, start, rows, wide, maps[s], planes[k], numbers, height, width, warped, seen)
            _compare(own, warped, seen, counts, means, weights, height, columns, first, second)
        for i in range(height * columns):
            costs[k, i] = np.float32(0.5) * (first[i] + second[i])
    return costs.reshape((len(planes), height, columns))


@inline
def _counts(width: int, columns: int) -> Floats:
    """Return how many columns of the picture lie in the window around each."""
    counts = np.ones(columns, np.float32)
    for x in range(width):
        counts[x] = min(x + RADIUS, width - 1) - max(x - RADIUS, 0) + 1
    return counts


@inline
def _rows_within(y: int, height: int) -> int:
    return min(y + RADIUS, height - 1) - max(y - RADIUS, 0) + 1


@inline
def _warp(
    sources: Integers, start: int, rows: int, wide: int, m: Floats, d: float, numbers: Floats, height: int, width: int,
    warped: Floats, seen: Floats,
) -> None:  # fmt: skip
    """Set ``warped`` to a source as the view would show it on the plane, and ``seen`` to whether it lies in it."""
    columns = len(numbers)
    stride = columns + 2 * MARGIN
    right, low = wide - 2 * BORDER - EDGE, rows - 2 * BORDER - EDGE
    for y in range(height):
        px, py = m[1] * y + m[2] + d * m[9], m[4] * y + m[5] + d * m[10]
        pz = m[7] * y + m[8] + d * m[11]
        for at in range(0, columns, LANES):
            x = load(numbers, at)
            depth = m[6] * x + pz
            inverse = 1.0 / maximum(depth, 1e-6)
            u, v = (m[0] * x + px) * inverse, (m[3] * x + py) * inverse
            # clamped numbers differ from the numbers themselves where those lie outside; NaN cannot be
            inside_u, inside_v = minimum(maximum(u, 0.0), right), minimum(maximum(v, 0.0), low)
            grey = sample(sources, start, wide, inside_u + BORDER, inside_v + BORDER)
            store(warped, y * stride + MARGIN + at, where(x < width, grey, 0.0))
            near = (depth > 1e-6) & (u >= -0.5) & (u <= right + 0.5)
            near = near & (v >= -0.5) & (v <= low + 0.5)
            store(seen, y * columns + at, where(near, broadcast(1.0), 0.0))


@inline
def _slide(own: Floats, other: Floats, sums: Floats, y: int, height: int, stride: int) -> None:
    """Move the sums over columns of windows one row down, to those around row ``y``.

    ``sums`` holds three rows: of ``other``, of its squares, and of its products with ``own``.
    """
    for at in range(MARGIN, stride - MARGIN, LANES):
        total, squares, products = load(sums, at), load(sums, stride + at), load(sums, 2 * stride + at)
        if y + RADIUS < height:
            place = (y + RADIUS) * stride + at
            value = load(other, place)
            total, squares = total + value, squares + value * value
            products = products + value * load(own, place)
        if y - RADIUS - 1 >= 0:
            place = (y - RADIUS - 1) * stride + at
            value = load(other, place)
            total, squares = total - value, squares - value * value
            products = products - value * load(own, place)
        store(sums, at, total)
        store(sums, stride + at, squares)
        store(sums, 2 * stride + at, products)


@inline
def _across(sums: Floats, at: int) -> Number:
    """Return the sums over windows of sixteen columns, of their sums over columns, from place ``at`` on."""
    total = load(sums, at)
    for k in range(1, RADIUS + 1):
        total = total + (load(sums, at - k) + load(sums, at + k))
    return total


@inline
def _own_moments(own: Floats, counts: Floats, height: int, columns: int, means: Floats, weights: Floats) -> None:
    """Set the mean of each window of the view, and one through its standard deviation."""
    stride = columns + 2 * MARGIN
    sums = np.zeros(3 * stride, np.float32)
    for y in range(-RADIUS, height):
        _slide(own, own, sums, y, height, stride)
        if y >= 0:
            for at in range(0, columns, LANES):
                share = 1.0 / (load(counts, at) * np.float32(_rows_within(y, height)))
                mean = _across(sums, MARGIN + at) * share
                variance = maximum(_across(sums, stride + MARGIN + at) * share - mean * mean, 0.0)
                store(means, y * columns + at, mean)
                store(weights, y * columns + at, 1.0 / square_root(variance + NOISE))


@inline
def _compare(
    own: Floats, warped: Floats, seen: Floats, counts: Floats, means: Floats, weights: Floats, height: int,
    columns: int, first: Floats, second: Floats,
) -> None:  # fmt: skip
    """Let the costs of one source at one plane take part in the best two of each pixel."""
    stride = columns + 2 * MARGIN
    sums = np.zeros(3 * stride, np.float32)
    for y in range(-RADIUS, height):
        _slide(own, warped, sums, y, height, stride)
        if y >= 0:
            for at in range(0, columns, LANES):
                place = y * columns + at
                sees = load(seen, place) > 0.5
                if not any_of(sees):
                    continue
                share = 1.0 / (load(counts, at) * np.float32(_rows_within(y, height)))
                mean = _across(sums, MARGIN + at) * share
                squares = _across(sums, stride + MARGIN + at) * share
                products = _across(sums, 2 * stride + MARGIN + at) * share
                variance = maximum(squares - mean * mean, 0.0) + NOISE
                covariance = products - mean * load(means, place)
                match = covariance * load(weights, place) * inverse_root(variance)
                cost = where(sees, 1.0 - match, UNKNOWN)
                best, next_ = load(first, place), load(second, place)
                store(second, place, minimum(next_, maximum(best, cost)))
                store(first, place, minimum(best, cost))
