"""Which Gaussians touch which tile: depth order, exact ellipse extents, tile lists.

The Gaussians are sorted by depth once; going through them in that order and appending to each tile's list leaves every
list sorted, which saves the sort by (tile, depth) of GPU rasterisers. A Gaussian touches a tile if the ellipse on which
its opacity is 1/255 reaches the tile's pixel centres: the test is exact for each row of tiles, not a bounding square.
"""

import numpy as np

from avs.rasterizer.kernels import Floats, Integers, inline, kernel
from avs.rasterizer.simd import ceil, floor, maximum, minimum, square_root, where
from avs.rasterizer.simd_memory import aligned_empty, aligned_full, load, store
from avs.rasterizer.simd_types import LANES
from avs.rasterizer.splat_records import LOG2_ALPHA_MIN, LOG_OPACITY, RADIUS_X, RADIUS_Y, XX, XY, YY, X, Y

TILE = 8
# Beyond any image's last column.
_FAR = 1e6
# Pixels, and share of the squared Mahalanobis distance, by which an ellipse is widened, so that rounding in the float32
# blending loop, which decides, cannot find a pixel outside.
_SLACK = 0.01
_SLACK_LEVEL = 1e-3
# Row of ``ellipses`` after those that are numbered as the columns of a record: first row of pixels.
_TOP = LOG_OPACITY + 1
# Keeps the extents finite where a long, thin ellipse's determinant is lost in rounding.
_LEAST_DETERMINANT = 1e-30


@kernel
def depth_order(depths: Floats, radii: Integers) -> Integers:
    """Return the indices of the visible Gaussians (radius above 0) from near to far, ties in index order.

    A radix sort of the bits of the depths, which for non-negative floats order as the numbers do.
    """
    keys = depths.view(np.uint32)
    order: Integers = np.empty(len(depths), np.int32)
    count = 0
    for i in range(len(depths)):
        if radii[i, 0] > 0:
            order[count] = i
            count += 1
    order = order[:count]
    histogram = np.zeros((3, 2048), np.int64)
    for i in order:
        key = keys[i]
        histogram[0, key & np.uint32(2047)] += 1
        histogram[1, (key >> np.uint32(11)) & np.uint32(2047)] += 1
        histogram[2, key >> np.uint32(22)] += 1
    other: Integers = np.empty(count, np.int32)
    for digit in range(3):
        shift = np.uint32(11 * digit)
        total = 0
        for b in range(2048):
            here = histogram[digit, b]
            histogram[digit, b] = total
            total += here
        for i in order:
            bucket = (keys[i] >> shift) & np.uint32(2047)
            other[histogram[digit, bucket]] = i
            histogram[digit, bucket] += 1
        order, other = other, order
    return order


@inline
def grown(array: Integers, used: int, extra: int) -> Integers:
    """Return ``array``, or a longer copy, with room for ``extra`` more elements than ``used``."""
    if used + extra <= len(array):
        return array
    longer = np.empty(max(2 * len(array), used + extra), array.dtype)
    for k in range(used):
        longer[k] = array[k]
    return longer


@inline
def _next_live(live: Integers, columns: int, rows: int) -> Integers:
    """Return, per row and column, the first column from there on with a live tile; ``columns`` if there is none."""
    following = np.empty((rows, columns + 1), np.int32)
    for row in range(rows):
        following[row, columns] = columns
        for column in range(columns - 1, -1, -1):
            following[row, column] = column if live[row * columns + column] else following[row, column + 1]
    return following


@inline
def _spans(ellipses: Floats, height: int, spans: Floats) -> None:
    """Fill ``spans [height, 2, 16]`` with the first and last tile columns of sixteen ellipses, row of tiles by row.

    ``ellipses`` are vectors of sixteen: centre relative to the first pixel's (x, y), a record's quadratic form and
    logarithm of the opacity, first row of pixels. A row that is not met ends at column -1.
    """
    # a dx^2 + 2 b dx dy + c dy^2 <= level inside the ellipse
    x, y = load(ellipses, X * LANES), load(ellipses, Y * LANES)
    a, b, c = -load(ellipses, XX * LANES), -0.5 * load(ellipses, XY * LANES), -load(ellipses, YY * LANES)
    level = maximum(load(ellipses, LOG_OPACITY * LANES) - LOG2_ALPHA_MIN, 0.0) * (1.0 + _SLACK_LEVEL)
    row = load(ellipses, _TOP * LANES) - y
    determinant = maximum(a * c - b * b, _LEAST_DETERMINANT)
    inverse = 1.0 / a
    half_height = square_root(level * a / determinant)
    # where the ellipse reaches farthest right; the leftmost point is opposite
    turn = -b * square_root(level / (c * determinant))
    squared = a * level
    for r in range(height):
        low = maximum(row, -half_height)
        high = minimum(row + float(TILE - 1), half_height)
        at_right = minimum(maximum(turn, low), high)
        at_left = minimum(maximum(-turn, low), high)
        reach_right = square_root(maximum(squared - determinant * at_right * at_right, 0.0)) - b * at_right
        reach_left = square_root(maximum(squared - determinant * at_left * at_left, 0.0)) + b * at_left
        first = ceil(x - reach_left * inverse - _SLACK)
        last = floor(x + reach_right * inverse + _SLACK)
        met = (first <= last) & (low <= high + _SLACK)
        store(spans, 2 * r * LANES, floor(maximum(first, 0.0) * (1.0 / TILE)))
        store(spans, (2 * r + 1) * LANES, where(met, floor(minimum(last, _FAR) * (1.0 / TILE)), -1.0))
        row = row + float(TILE)


@inline
def _gather(records: Floats, place: int, following: Integers, ellipses: Floats, boxes: Integers) -> tuple[int, int]:
    """Take the next Gaussians, up to sixteen, that may touch a live tile. Return the next place and how many there are.

    ``boxes [16, 5]`` gets each one's place and box of tiles: left, right, top, bottom.
    """
    half, zero = np.float32(0.5), np.float32(0.0)
    rows, columns = following.shape[0], following.shape[1] - 1
    count = 0
    while place < len(records) and count < LANES:
        x, y = records[place, X] - half, records[place, Y] - half
        radius_x, radius_y = records[place, RADIUS_X], records[place, RADIUS_Y]
        left = int(max(np.ceil(x - radius_x), zero)) >> 3
        right = int(min(np.floor(x + radius_x), np.float32(TILE * columns - 1))) >> 3
        top = int(max(np.ceil(y - radius_y), zero)) >> 3
        bottom = int(min(np.floor(y + radius_y), np.float32(TILE * rows - 1))) >> 3
        while top <= bottom and following[top, left] > right:
            top += 1
        if top <= bottom:
            boxes[count, 0], boxes[count, 1], boxes[count, 2] = place, left, right
            boxes[count, 3], boxes[count, 4] = top, bottom
            ellipses[X * LANES + count] = x
            ellipses[Y * LANES + count] = y
            for k in range(4):
                ellipses[(XX + k) * LANES + count] = records[place, XX + k]
            ellipses[_TOP * LANES + count] = np.float32(TILE * top)
            count += 1
        place += 1
    return place, count


@kernel
def tile_lists(
    records: Floats, start: int, budget: int, columns: int, rows: int, live: Integers, offsets: Integers, base: int,
    entries: Integers, used: int,
) -> tuple[int, Integers, int]:  # fmt: skip
    """Append the lists of the next Gaussians, from place ``start`` on, until ``budget`` entries are there.

    Args:
        records: the Gaussians from near to far, as :mod:`~avs.rasterizer.splat_records` lays them out.
        start: first place in ``records`` to take.
        budget: end after the Gaussian that reaches this number of entries.
        columns: tiles in a row.
        rows: rows of tiles.
        live: per tile, 0 if it needs no more entries.
        offsets: filled, ``tiles + 1`` of them from ``base`` on: where each tile's list begins in ``entries``.
        base: first place in ``offsets`` to fill.
        entries: places in ``records``, tile by tile; replaced by a longer array where it is too short.
        used: how many of ``entries`` are taken already.

    Returns:
        The next place in ``records``, ``entries``, and the new ``used``.
    """
    following = _next_live(live, columns, rows)
    ellipses = aligned_full((_TOP + 1) * LANES, 1.0)
    boxes = np.empty((LANES, 5), np.int64)
    spans = aligned_empty(2 * rows * LANES)
    # sixteen Gaussians may go beyond the budget by what they touch themselves
    tiles = np.empty(budget + LANES * columns * rows, np.int32)
    places = np.empty(budget + LANES * columns * rows, np.int32)
    counts = np.zeros(columns * rows + 1, np.int32)
    found = 0
    place = start
    while place < len(records) and found < budget:
        place, count = _gather(records, place, following, ellipses, boxes)
        height = 0
        for lane in range(count):
            height = max(height, boxes[lane, 4] - boxes[lane, 3] + 1)
        _spans(ellipses, height, spans)
        for lane in range(count):
            top = boxes[lane, 3]
            for row in range(top, boxes[lane, 4] + 1):
                at = 2 * LANES * (row - top) + lane
                first = row * columns + max(int(spans[at]), boxes[lane, 1])
                last = row * columns + min(int(spans[at + LANES]), boxes[lane, 2])
                for tile in range(first, last + 1):
                    # written in any case, kept if the tile is live
                    tiles[found] = tile
                    places[found] = boxes[lane, 0]
                    alive = int(live[tile] != 0)
                    counts[tile + 1] += alive
                    found += alive
    entries = grown(entries, used, found)
    offsets[base] = used
    for tile in range(columns * rows):
        offsets[base + tile + 1] = offsets[base + tile] + counts[tile + 1]
        counts[tile + 1] = offsets[base + tile]
    for e in range(found):
        tile = tiles[e] + 1
        entries[counts[tile]] = places[e]
        counts[tile] += 1
    return place, entries, used + found
