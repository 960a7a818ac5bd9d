"""Refinement of depth by PatchMatch (Bleyer et al. 2011, Schoenberger et al. 2016): a slanted plane for each pixel.

The surface at a pixel is a small plane, on which the inverse depth is linear in the pixel's coordinates. A pixel tries
the planes of its neighbours and random changes of its own, and keeps what fits the sources best. Pixels are visited as
the fields of a chess-board, first those of one colour, then the others, so that their order makes no difference and
sixteen of one row can be computed at once.

Such pixels lie in ``[2, height, stride]`` arrays: colour, row, and half of the column, see ``halves``. The colour of
column x in row y is ``(x + y) % 2``.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.rasterizer.kernels import Floats, Integers, Number, inline, kernel
from avs.rasterizer.simd import LANES, absolute, broadcast, exp2, maximum, minimum, square_root, where
from avs.rasterizer.simd_memory import load, store
from avs.sfm.plane_sweep import NOISE, UNKNOWN
from avs.sfm.stereo_vectors import EDGE, nearest, sample

IMPOSSIBLE = 2.0
"""Cost of a plane that no source sees: that of no correlation at all is 1."""

SOFTNESS = 15.0
"""Grey values by which a pixel of the window may differ from the middle one and still belong to its surface."""

STEEPEST = 5.0
"""Tangent of the angle between a surface and the picture, at most."""

AGREEMENT, TOLERANCE = 0.3, 0.02
"""Cost of a depth that a source's own depth contradicts, and by how much, relative to it, they then differ at least."""

TRIALS = 3
"""Random changes at each visit: of the depth, of the slope, of both. Each takes three numbers."""

MARGIN = LANES
"""Places at either end of a row, so that neighbours need no cases."""

NOWHERE = -1.0
"""Inverse depth of places that are no pixels."""

FloatMap = npt.NDArray[np.float32]


def halves(values: FloatMap, outside: float) -> FloatMap:
    """Return the numbers ``[height, width]`` of pixels by colour, ``[2, height + 2, stride]``.

    Args:
        values: of the pixels.
        outside: of places that are no pixels: a row above and one below, and the ends of rows.
    """
    height, width = values.shape
    sorted_ = np.full((2, height + 2, _stride(width)), outside, dtype=np.float32)
    for color in range(2):
        for odd in range(2):  # rows of one parity
            own = values[odd::2, (odd + color) % 2 :: 2]
            sorted_[color, 1 + odd : 1 + height : 2, MARGIN : MARGIN + own.shape[1]] = own
    return sorted_


def whole(sorted_: FloatMap, width: int) -> FloatMap:
    """Return the numbers of pixels by row and column from those by colour."""
    height = sorted_.shape[1] - 2
    values = np.empty((height, width), dtype=np.float32)
    for color in range(2):
        for odd in range(2):
            own = values[odd::2, (odd + color) % 2 :: 2]
            own[:] = sorted_[color, 1 + odd : 1 + height : 2, MARGIN : MARGIN + own.shape[1]]
    return values


def columns_apart(grey: npt.NDArray[np.uint8], reach: int) -> FloatMap:
    """Return a picture with its even and its odd columns apart, ``[2, height + 2 reach, stride]``, edges repeated."""
    height, width = grey.shape
    stride = _stride(width)
    columns = 2 * (np.arange(stride) - MARGIN)
    rows = np.clip(np.arange(-reach, height + reach), 0, height - 1)
    return np.stack([grey[rows][:, np.clip(columns + odd, 0, width - 1)] for odd in range(2)]).astype(np.float32)


def _stride(width: int) -> int:
    return -(-width // (2 * LANES)) * LANES + 2 * MARGIN


@kernel
def visit(
    apart: Floats, sources: Integers, depths: Floats, sizes: Integers, maps: Floats, offsets: Integers, noise: Floats,
    state: Floats, bounds: Floats, width: int, first: bool,
) -> None:  # fmt: skip
    """Visit every pixel once, and improve the planes in place.

    Args:
        apart: of ``columns_apart``, flat, with the greatest offset for its reach.
        sources: packed pictures of s views, see ``plane_sweep.sweep``.
        depths: inverse depths of the sources, likewise, 0 where they are not known; or empty, if none are.
        sizes: ``[s * 3]``, see there.
        maps: ``[s * 12]``, see there.
        offsets: ``[samples, 2]`` int64, columns and rows of the window's pixels from its middle.
        noise: ``[3 * TRIALS, 2, height, stride]`` float32 in -1..1, random.
        state: ``[4, 2, height + 2, stride]`` float32, of ``halves``: inverse depths, their changes by one column, those
            by one row, and matching costs.
        bounds: ``[5]`` float32: least and greatest inverse depth; the greatest random change of it, and of a slope in
            shares of the inverse depth; the steepest slope in such shares.
        width: of the picture in pixels.
        first: whether the costs of the planes are not known yet.
    """
    _, _, tall, stride = state.shape
    height, reach = tall - 2, (apart.size // (2 * stride) - (tall - 2)) // 2
    flat, random = state.reshape(-1), noise.reshape(-1)
    weights, own = np.zeros(len(offsets) * LANES, np.float32), np.zeros(len(offsets) * LANES, np.float32)
    lanes = np.arange(LANES).astype(np.float32)
    for color in range(2):
        for y in range(height):
            odd = (y + color) % 2
            for j in range(MARGIN, stride - MARGIN, LANES):
                x = 2.0 * (load(lanes, 0) + np.float32(j - MARGIN)) + np.float32(odd)
                spread = _set_window(apart, offsets, weights, own, y, j, odd, height, stride, reach)
                scene = (weights, own, offsets, sources, sizes, maps, bounds, depths)
                view = (x, np.float32(y), spread)
                at = (color * tall + y + 1) * stride + j
                now = _plane_at(flat, at, 2 * tall * stride)
                cost = load(flat, 3 * 2 * tall * stride + at)
                if first:
                    cost = _cost(scene, view, now)
                beside = ((1 - color) * tall + y + 1) * stride + j
                for side in range(4):
                    if side < 2:
                        place, dx, dy = beside - 1 + odd + side, 2 * side - 1, 0
                    else:
                        place, dx, dy = beside + (2 * side - 5) * stride, 0, 2 * side - 5
                    there, across, down = _plane_at(flat, place, 2 * tall * stride)
                    moved = there - across * np.float32(dx) - down * np.float32(dy)
                    # a place that is no pixel stays nowhere
                    now, cost = _better(scene, view, now, cost, (where(there > 0.0, moved, there), across, down))
                for trial in range(TRIALS):
                    tried = _changed(
                        random, 3 * trial, (color * height + y) * stride + j, 2 * height * stride, now, bounds
                    )
                    now, cost = _better(scene, view, now, cost, tried)
                inside = x < width
                store(flat, at, where(inside, now[0], NOWHERE))
                store(flat, 2 * tall * stride + at, now[1])
                store(flat, 4 * tall * stride + at, now[2])
                store(flat, 6 * tall * stride + at, cost)


@inline
def _plane_at(state: Floats, at: int, step: int) -> Number:
    return load(state, at), load(state, step + at), load(state, 2 * step + at)


@inline
def _changed(random: Floats, row: int, at: int, step: int, plane: Number, bounds: Floats) -> Number:
    """Return planes with a random change of the depth, of the slope or of both, as ``row`` says."""
    there, across, down = plane
    if row != 3:
        there = there + load(random, row * step + at) * bounds[2]
    if row != 0:
        slope = there * bounds[3]
        across = across + load(random, (row + 1) * step + at) * slope
        down = down + load(random, (row + 2) * step + at) * slope
    return there, across, down


@inline
def _better(scene: Number, view: Number, now: Number, cost: Number, plane: Number) -> Number:
    """Return for each of sixteen pixels the better of two planes, and its cost; ``cost`` is that of ``now``."""
    there, across, down = plane
    bounds = scene[6]
    steepest = there * bounds[4]
    allowed = (there >= bounds[0]) & (there <= bounds[1])
    allowed = allowed & (absolute(across) <= steepest) & (absolute(down) <= steepest)
    other = where(allowed, _cost(scene, view, plane), IMPOSSIBLE)
    taken = other < cost
    plane = (where(taken, there, now[0]), where(taken, across, now[1]), where(taken, down, now[2]))
    return plane, where(taken, other, cost)


@inline
def _set_window(
    apart: Floats, offsets: Integers, weights: Floats, own: Floats, y: int, j: int, odd: int, height: int, stride: int,
    reach: int,
) -> Number:  # fmt: skip
    """Set the weights of the windows' pixels, of sum 1, and their grey values less the mean, weighted.

    Return one through the standard deviation of each window.
    """
    tall = height + 2 * reach
    middle = load(apart, (odd * tall + y + reach) * stride + j)
    total, sums = broadcast(0.0), broadcast(0.0)
    for k in range(len(offsets)):
        column, row = odd + offsets[k, 0], y + reach + offsets[k, 1]
        grey = load(apart, ((column & 1) * tall + row) * stride + j + (column >> 1))
        away = (grey - middle) * (1.0 / SOFTNESS)
        weight = exp2(maximum(-0.5 * away * away, -20.0))
        store(weights, k * LANES, weight)
        store(own, k * LANES, grey)
        total, sums = total + weight, sums + weight * grey
    share = 1.0 / total
    mean, squares = sums * share, broadcast(0.0)
    for k in range(len(offsets)):
        weight, centered = load(weights, k * LANES) * share, load(own, k * LANES) - mean
        store(weights, k * LANES, weight)
        store(own, k * LANES, weight * centered)
        squares = squares + weight * centered * centered
    return 1.0 / square_root(squares + NOISE)


@inline
def _cost(scene: Number, view: Number, plane: Number) -> Number:
    """Return the mean costs of sixteen planes in the best two sources of each."""
    first, second = broadcast(IMPOSSIBLE), broadcast(IMPOSSIBLE)
    for s in range(len(scene[4]) // 3):
        cost = _cost_in(scene, s, view, plane)
        second = minimum(second, maximum(first, cost))
        first = minimum(first, cost)
    lonely = where(first < IMPOSSIBLE, broadcast(UNKNOWN), IMPOSSIBLE)
    return 0.5 * (first + minimum(second, lonely))


@inline
def _cost_in(scene: Number, s: int, view: Number, plane: Number) -> Number:
    """Return the costs of planes in one source, one less the weighted correlation; ``IMPOSSIBLE`` where not seen."""
    weights, own, offsets, sources, sizes, maps, _, depths = scene
    x, y, spread = view
    there, across, down = plane
    m, start, rows, wide = 12 * s, sizes[3 * s], sizes[3 * s + 1], sizes[3 * s + 2]
    right, low = wide - EDGE, rows - EDGE
    px = maps[m] * x + (maps[m + 9] * there + (maps[m + 1] * y + maps[m + 2]))
    py = maps[m + 3] * x + (maps[m + 10] * there + (maps[m + 4] * y + maps[m + 5]))
    pz = maps[m + 6] * x + (maps[m + 11] * there + (maps[m + 7] * y + maps[m + 8]))
    seen = (pz > 1e-6) & (px >= 0.0) & (py >= 0.0) & (px <= right * pz) & (py <= low * pz)
    xx, xy = maps[m] + across * maps[m + 9], maps[m + 1] + down * maps[m + 9]
    yx, yy = maps[m + 3] + across * maps[m + 10], maps[m + 4] + down * maps[m + 10]
    zx, zy = maps[m + 6] + across * maps[m + 11], maps[m + 7] + down * maps[m + 11]
    sums, squares, products = broadcast(0.0), broadcast(0.0), broadcast(0.0)
    for k in range(len(offsets)):
        column, row = np.float32(offsets[k, 0]), np.float32(offsets[k, 1])
        depth = zx * column + (zy * row + pz)
        seen = seen & (depth > 1e-6)
        inverse = 1.0 / depth
        u = minimum(maximum((xx * column + (xy * row + px)) * inverse, 0.0), right)
        v = minimum(maximum((yx * column + (yy * row + py)) * inverse, 0.0), low)
        grey = sample(sources, start, wide, u, v)
        weighted = load(weights, k * LANES) * grey
        sums, squares = sums + weighted, squares + weighted * grey
        products = products + load(own, k * LANES) * grey
    variance = maximum(squares - sums * sums, 0.0) + NOISE
    cost = 1.0 - products * spread / square_root(variance)
    if len(depths) > 0:
        inverse = 1.0 / pz
        u, v = minimum(maximum(px * inverse, 0.0), right), minimum(maximum(py * inverse, 0.0), low)
        apart = absolute(nearest(depths, start, wide, u, v) * pz / there - 1.0)
        cost = cost + AGREEMENT * minimum(apart * (1.0 / TOLERANCE), 1.0)
    return where(seen, cost, IMPOSSIBLE)
