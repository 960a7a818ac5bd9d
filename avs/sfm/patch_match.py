"""Refinement of depth by PatchMatch (Bleyer et al. 2011, Schoenberger et al. 2016): a slanted plane for each pixel.

The surface at a pixel is a small plane, on which the inverse depth is linear in the pixel's coordinates. A pixel tries
the planes of its neighbours and random changes of its own, and keeps what fits the sources best. Pixels are visited as
the fields of a chess-board, see ``avs.sfm.chess_board``.
"""

from __future__ import annotations

import numpy as np

from avs.rasterizer.kernels import Floats, Integers, Number, inline, kernel
from avs.rasterizer.simd import absolute, broadcast, exp2, fma, maximum, minimum, square_root, where
from avs.rasterizer.simd_memory import aligned_empty, load, store
from avs.rasterizer.simd_types import LANES
from avs.sfm.chess_board import MARGIN, NOWHERE
from avs.sfm.plane_sweep import NOISE, UNKNOWN
from avs.sfm.stereo_vectors import BORDER, EDGE, count_of, inverse_root, nearest, sample

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

RADIUS = 2
"""Of the windows: 5 x 5 pixels."""

SIDE, SAMPLES = 2 * RADIUS + 1, (2 * RADIUS + 1) ** 2
"""Pixels of a window, along a side and in all."""

STRETCH = (BORDER - 2) / (2 * RADIUS)
"""Pixels of a source that one pixel of the view is long at most, along an axis: windows stay in the border."""


@kernel
def visit(
    apart: Floats, sources: Integers, depths: Floats, sizes: Integers, maps: Floats, noise: Floats, state: Floats,
    bounds: Floats, width: int, few: int,
) -> None:  # fmt: skip
    """Visit every pixel once, and improve the planes in place.

    Args:
        apart: of ``columns_apart``, flat, with a reach of ``RADIUS``.
        sources: packed pictures of s views, see ``plane_sweep.sweep``.
        depths: inverse depths of the sources, likewise, 0 where they are not known; or empty, if none are.
        sizes: ``[s * 3]``, see there.
        maps: ``[s * 12]``, see there.
        noise: ``[3 * TRIALS, 2, height, stride]`` float32 in -1..1, random.
        state: ``[4, 2, height + 2, stride]`` float32, of ``halves``: inverse depths, their changes by one column, those
            by one row, and matching costs.
        bounds: ``[5]`` float32: least and greatest inverse depth; the greatest random change of it, and of a slope in
            shares of the inverse depth; the steepest slope in such shares.
        width: of the picture in pixels.
        few: sources in which a new plane is compared, those that suit the planes before best.
    """
    _, _, tall, stride = state.shape
    height = tall - 2
    flat, random = state.reshape(-1), noise.reshape(-1)
    active, each = np.zeros(min(few, len(sizes) // 3), np.int64), aligned_empty(len(sizes) // 3 * LANES)
    weights, own = aligned_empty(SAMPLES * LANES), aligned_empty(SAMPLES * LANES)
    lanes = np.arange(LANES).astype(np.float32)
    for color in range(2):
        for y in range(height):
            odd = (y + color) % 2
            for j in range(MARGIN, stride - MARGIN, LANES):
                x = 2.0 * (load(lanes, 0) + np.float32(j - MARGIN)) + np.float32(odd)
                spread = _set_window(apart, weights, own, y, j, odd, height, stride)
                scene = (weights, own, sources, sizes, maps, bounds, depths, active)
                view = (x, np.float32(y), spread)
                at = (color * tall + y + 1) * stride + j
                now = _plane_at(flat, at, 2 * tall * stride)
                cost = _cost_in_all(scene, view, now, each)
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
    bounds = scene[5]
    steepest = there * bounds[4]
    allowed = (there >= bounds[0]) & (there <= bounds[1])
    allowed = allowed & (absolute(across) <= steepest) & (absolute(down) <= steepest)
    other = where(allowed, _cost(scene, view, plane), IMPOSSIBLE)
    taken = other < cost
    plane = (where(taken, there, now[0]), where(taken, across, now[1]), where(taken, down, now[2]))
    return plane, where(taken, other, cost)


@inline
def _set_window(
    apart: Floats, weights: Floats, own: Floats, y: int, j: int, odd: int, height: int, stride: int
) -> Number:
    """Set the weights of the windows' pixels, of sum 1, and their grey values less the mean, weighted.

    Return one through the standard deviation of each window.
    """
    tall = height + 2 * RADIUS
    middle = load(apart, (odd * tall + y + RADIUS) * stride + j)
    total, sums = broadcast(0.0), broadcast(0.0)
    for k in range(SAMPLES):
        column, row = odd + k % SIDE - RADIUS, y + k // SIDE
        grey = load(apart, ((column & 1) * tall + row) * stride + j + (column >> 1))
        away = (grey - middle) * (1.0 / SOFTNESS)
        weight = exp2(maximum(-0.5 * away * away, -20.0))
        store(weights, k * LANES, weight)
        store(own, k * LANES, grey)
        total, sums = total + weight, sums + weight * grey
    share = 1.0 / total
    mean, squares = sums * share, broadcast(0.0)
    for k in range(SAMPLES):
        weight, centered = load(weights, k * LANES) * share, load(own, k * LANES) - mean
        store(weights, k * LANES, weight)
        store(own, k * LANES, weight * centered)
        squares = squares + weight * centered * centered
    return 1.0 / square_root(squares + NOISE)


@inline
def _cost(scene: Number, view: Number, plane: Number) -> Number:
    """Return the mean costs of sixteen planes in the best two active sources of each."""
    active = scene[7]
    first, second = broadcast(IMPOSSIBLE), broadcast(IMPOSSIBLE)
    for k in range(len(active)):
        cost = _cost_in(scene, active[k], view, plane)
        second = minimum(second, maximum(first, cost))
        first = minimum(first, cost)
    return _mean_of(first, second)


@inline
def _cost_in_all(scene: Number, view: Number, plane: Number, each: Floats) -> Number:
    """Return the mean costs of sixteen planes in the best two of all sources of each, and set the active sources.

    These are the sources that are among the best two of the most of the sixteen. What a plane costs in them alone is
    not less than what it costs in all, so that a plane that is taken for it is better indeed.
    """
    active, count = scene[7], len(scene[3]) // 3
    first, second = broadcast(IMPOSSIBLE), broadcast(IMPOSSIBLE)
    for s in range(count):
        cost = _cost_in(scene, s, view, plane)
        store(each, s * LANES, cost)
        second = minimum(second, maximum(first, cost))
        first = minimum(first, cost)
    taken = 0
    for k in range(len(active)):
        best, most = 0, -1
        for s in range(count):
            cost = load(each, s * LANES)
            votes = count_of((cost <= second) & (cost < IMPOSSIBLE))
            if votes > most and not (taken >> s) & 1:
                best, most = s, votes
        active[k] = best
        taken |= 1 << best
    return _mean_of(first, second)


@inline
def _mean_of(first: Number, second: Number) -> Number:
    """Return the mean of the best two costs; one of them alone counts with a cost of no correlation."""
    lonely = where(first < IMPOSSIBLE, broadcast(UNKNOWN), IMPOSSIBLE)
    return 0.5 * (first + minimum(second, lonely))


@inline
def _cost_in(scene: Number, s: int, view: Number, plane: Number) -> Number:
    """Return the costs of planes in one source, one less the weighted correlation; ``IMPOSSIBLE`` where not seen.

    A window is so small that it appears in the source as a parallelogram, nearly: the map by the plane is replaced by
    its derivative in the middle.
    """
    weights, own, sources, sizes, maps, _, depths, _ = scene
    x, y, spread = view
    there, across, down = plane
    m, start, rows, wide = 12 * s, sizes[3 * s], sizes[3 * s + 1], sizes[3 * s + 2]
    right, low = wide - 2 * BORDER - EDGE, rows - 2 * BORDER - EDGE
    px = maps[m] * x + (maps[m + 9] * there + (maps[m + 1] * y + maps[m + 2]))
    py = maps[m + 3] * x + (maps[m + 10] * there + (maps[m + 4] * y + maps[m + 5]))
    pz = maps[m + 6] * x + (maps[m + 11] * there + (maps[m + 7] * y + maps[m + 8]))
    seen = (pz > 1e-6) & (px >= 0.0) & (py >= 0.0) & (px <= right * pz) & (py <= low * pz)
    inverse = 1.0 / maximum(pz, 1e-6)
    u, v = minimum(maximum(px * inverse, 0.0), right), minimum(maximum(py * inverse, 0.0), low)
    zx, zy = maps[m + 6] + across * maps[m + 11], maps[m + 7] + down * maps[m + 11]
    ux = _stretch(maps[m] + across * maps[m + 9] - u * zx, inverse)
    uy = _stretch(maps[m + 1] + down * maps[m + 9] - u * zy, inverse)
    vx = _stretch(maps[m + 3] + across * maps[m + 10] - v * zx, inverse)
    vy = _stretch(maps[m + 4] + down * maps[m + 10] - v * zy, inverse)
    sums, squares, products = broadcast(0.0), broadcast(0.0), broadcast(0.0)
    for row in range(-RADIUS, RADIUS + 1):
        along, below = fma(uy, row, u + BORDER), fma(vy, row, v + BORDER)
        for column in range(-RADIUS, RADIUS + 1):
            grey = sample(sources, start, wide, fma(ux, column, along), fma(vx, column, below))
            k = ((row + RADIUS) * SIDE + column + RADIUS) * LANES
            weighted = load(weights, k) * grey
            sums, squares = sums + weighted, fma(weighted, grey, squares)
            products = fma(load(own, k), grey, products)
    variance = maximum(squares - sums * sums, 0.0) + NOISE
    cost = 1.0 - products * spread * inverse_root(variance)
    if len(depths) > 0:
        apart = absolute(nearest(depths, start, wide, u + BORDER, v + BORDER) * pz / there - 1.0)
        cost = cost + AGREEMENT * minimum(apart * (1.0 / TOLERANCE), 1.0)
    return where(seen, cost, IMPOSSIBLE)


@inline
def _stretch(change: Number, inverse: Number) -> Number:
    """Return how many pixels of a source one pixel of the view is long, within limits."""
    return minimum(maximum(change * inverse, -STRETCH), STRETCH)
