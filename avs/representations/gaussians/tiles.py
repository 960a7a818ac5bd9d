"""Which Gaussians touch which tile: depth order, exact ellipse extents, tile lists.

The Gaussians are sorted by depth once; going through them in that order and appending to each tile's list leaves every
list sorted, which saves the sort by (tile, depth) of GPU rasterisers. A Gaussian touches a tile if the ellipse on which
its opacity is 1/255 reaches the tile's pixel centres: the test is exact for each row of tiles, not a bounding square.
"""

import numpy as np

from avs.representations.gaussians.kernels import inline, kernel

TILE = 8
# Pixels, and share of the squared Mahalanobis distance, by which an ellipse is widened, so that rounding in the float32
# blending loop, which decides, cannot find a pixel outside.
_SLACK = 0.01
_SLACK_LEVEL = 1e-3


@kernel
def depth_order(depths, radii):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Return the indices of the visible Gaussians (radius above 0) from near to far, ties in index order.

    A radix sort of the bits of the depths, which for non-negative floats order as the numbers do.
    """
    keys = depths.view(np.uint32)
    order = np.empty(len(depths), np.int32)
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
    other = np.empty(count, np.int32)
    for digit in range(3):
        shift = np.uint32(11 * digit)
        total = 0
        for b in range(2048):
            here = histogram[digit, b]
            histogram[digit, b] = total
            total += here
        for i in order:
            b = (keys[i] >> shift) & np.uint32(2047)
            other[histogram[digit, b]] = i
            histogram[digit, b] += 1
        order, other = other, order
    return order


@inline
def _span(a, b, determinant, level, turn, low, high):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return the interval of dx that ``a dx^2 + 2 b dx dy + c dy^2 <= level`` covers for dy in low..high."""
    right = min(max(turn, low), high)
    left = min(max(-turn, low), high)
    reach_right = (-b * right + np.sqrt(max(a * level - determinant * right * right, 0.0))) / a
    reach_left = (-b * left - np.sqrt(max(a * level - determinant * left * left, 0.0))) / a
    return reach_left - _SLACK, reach_right + _SLACK


@inline
def _grown(array, used, extra):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return ``array``, or a longer copy, with room for ``extra`` more elements than ``used``."""
    if used + extra <= len(array):
        return array
    longer = np.empty(max(2 * len(array), used + extra), array.dtype)
    longer[:used] = array[:used]
    return longer


@kernel
def tile_lists(order, start, budget, means2d, conics, opacities, columns, rows, live, offsets, entries, used):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Append the lists of the next Gaussians, from place ``start`` of ``order`` on, until ``budget`` entries are there.

    Args:
        order: indices of the Gaussians from near to far.
        start: first place in ``order`` to take.
        budget: end after the Gaussian that reaches this number of entries.
        means2d: centres in pixels ``[N, 2]``.
        conics: ``[N, 3]``.
        opacities: ``[N]``.
        columns: tiles in a row.
        rows: rows of tiles.
        live: per tile, 0 if it needs no more entries.
        offsets: ``[tiles + 1]``, filled: where each tile's list begins in ``entries``.
        entries: places in ``order``, tile by tile; replaced by a longer array where it is too short.
        used: how many of ``entries`` are taken already.

    Returns:
        The next place in ``order``, ``entries``, and the new ``used``.
    """
    tiles = np.empty(2 * budget, np.int32)
    places = np.empty(2 * budget, np.int32)
    counts = np.zeros(columns * rows + 1, np.int32)
    found = 0
    place = start
    while place < len(order) and found < budget:
        i = order[place]
        a, b, c = np.float64(conics[i, 0]), np.float64(conics[i, 1]), np.float64(conics[i, 2])
        x, y = means2d[i, 0] - 0.5, means2d[i, 1] - 0.5
        determinant = a * c - b * b
        level = 2.0 * np.log(255.0 * np.float64(opacities[i])) * (1.0 + _SLACK_LEVEL)
        if level >= 0.0 and determinant > 0.0:
            half_height = np.sqrt(level * a / determinant)
            turn = -b * np.sqrt(level / (c * determinant))
            first = max(np.ceil(y - half_height - _SLACK), 0.0)
            last = min(np.floor(y + half_height + _SLACK), TILE * rows - 1.0)
            if first <= last:
                top, bottom = int(first) // TILE, int(last) // TILE
                tiles = _grown(tiles, found, columns * (bottom - top + 1))
                places = _grown(places, found, columns * (bottom - top + 1))
                for row in range(top, bottom + 1):
                    low = max(TILE * row - y, -half_height)
                    high = min(TILE * row + (TILE - 1) - y, half_height)
                    near, far = _span(a, b, determinant, level, turn, low, high)
                    near = max(np.ceil(x + near), 0.0)
                    far = min(np.floor(x + far), TILE * columns - 1.0)
                    if near <= far:
                        for tile in range(row * columns + int(near) // TILE, row * columns + int(far) // TILE + 1):
                            if live[tile]:
                                tiles[found] = tile
                                places[found] = place
                                counts[tile + 1] += 1
                                found += 1
        place += 1
    entries = _grown(entries, used, found)
    offsets[0] = used
    for tile in range(columns * rows):
        offsets[tile + 1] = offsets[tile] + counts[tile + 1]
        counts[tile + 1] = offsets[tile]
    for e in range(found):
        tile = tiles[e] + 1
        entries[counts[tile]] = places[e]
        counts[tile] += 1
    return place, entries, used + found
