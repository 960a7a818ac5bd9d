"""Depth from matching costs by semi-global matching (Hirschmueller 2008): neighbours tend to lie at the same depth.

The cost of a depth at a pixel is its own matching cost and the least cost of a path that leads there along a row or a
column, on which every change of depth costs something. Where the picture is flat, the depth thus comes from around.
"""

from __future__ import annotations

import numpy as np

from avs.rasterizer.kernels import Floats, Integers, Number, inline, kernel
from avs.rasterizer.simd import broadcast, minimum
from avs.rasterizer.simd_memory import load, store
from avs.rasterizer.simd_types import LANES
from avs.sfm.stereo_vectors import least_of

STEP, JUMP = 0.05, 0.5
"""What a change by one plane costs, and by more; matching costs lie in 0..2."""

EDGE_STEP = 8.0
"""Grey values between neighbours that halve the cost of a jump: edges of depth tend to be edges of the picture."""

_FAR = 1e9
"""Greater than any cost."""


@kernel
def smoothed(costs: Floats, grey: Integers) -> Floats:
    """Return the costs with those of the paths from the four sides added, ``[height, width, planes]``.

    Args:
        costs: matching costs, ``[height, width, planes]`` float32, planes a multiple of sixteen.
        grey: the picture, ``[height, width]`` uint8.
    """
    height, width, planes = costs.shape
    flat, total = costs.reshape(-1), np.zeros(height * width * planes, np.float32)
    room = planes + 2 * LANES
    for turned in range(2):
        length, lines = (width, height) if turned == 0 else (height, width)
        before, now = np.full(room, np.float32(_FAR)), np.full(room, np.float32(_FAR))
        for line in range(lines):
            for back in range(2):
                last, least = 0, np.float32(0.0)
                for step in range(length):
                    along = length - 1 - step if back else step
                    y, x = (line, along) if turned == 0 else (along, line)
                    value = int(grey[y, x])
                    jump = np.float32(JUMP / (1.0 + abs(value - last) / EDGE_STEP))
                    least = _go_on(flat, (y * width + x) * planes, planes, before, now, step == 0, least, jump, total)
                    before, now = now, before
                    last = value
    return total.reshape((height, width, planes))


@inline
def _go_on(
    costs: Floats, at: int, planes: int, before: Floats, now: Floats, first: bool, least: float, jump: float,
    total: Floats,
) -> Number:  # fmt: skip
    """Set the costs of a path at one more pixel, add them to ``total``, and return the least of them."""
    lowest = broadcast(_FAR)
    for k in range(0, planes, LANES):
        value = load(costs, at + k)
        if not first:
            near = minimum(load(before, LANES + k - 1), load(before, LANES + k + 1)) + STEP
            value = value + (minimum(minimum(load(before, LANES + k), near), least + max(jump, STEP)) - least)
        store(now, LANES + k, value)
        store(total, at + k, load(total, at + k) + value)
        lowest = minimum(lowest, value)
    return least_of(lowest)


@kernel
def winners(costs: Floats) -> Floats:
    """Return the plane of least cost of each pixel, ``[height, width]`` float32, between planes by a parabola."""
    height, width, planes = costs.shape
    best = np.empty((height, width), np.float32)
    for y in range(height):
        for x in range(width):
            k, least = 0, costs[y, x, 0]
            for other in range(1, planes):
                if costs[y, x, other] < least:
                    k, least = other, costs[y, x, other]
            best[y, x] = k
            if 0 < k < planes - 1:
                left, middle, right = costs[y, x, k - 1], costs[y, x, k], costs[y, x, k + 1]
                bend = left - 2 * middle + right
                if bend > 0:
                    best[y, x] = k + np.float32(0.5) * (left - right) / bend
    return best
