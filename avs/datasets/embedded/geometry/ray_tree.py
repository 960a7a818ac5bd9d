"""A tree of boxes around triangles, sixteen to a node, built by the surface area heuristic (Wald 2007, binned).

Sixteen children, and the sixteen triangles of a leaf, are what one operation of ``avs.rasterizer.simd`` handles (wide
trees: Wald, Benthin and Boulos 2008; Embree's are eight wide).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.rasterizer.kernels import Floats, Integers, inline, kernel
from avs.rasterizer.simd_types import LANES

Triangles = npt.NDArray[np.integer]

_BINS = 16
# Added around each triangle, in shares of the mesh's extent: as far as float32 may err in where a ray passes a border.
_MARGIN = 1e-6


@dataclass(frozen=True)
class RayTree:
    """What rays are sent through.

    Attributes:
        boxes: ``[n * 6 * 16]`` float32: of each node the lower x, y, z and the upper x, y, z of its sixteen children,
            in which nothing lies where there are fewer.
        children: ``[n * 16]`` int32: a node, or -1 minus a leaf.
        corners: ``[l * 9 * 16]`` float32: of each leaf's sixteen triangles the three corners; all 0 where there are
            fewer.
        members: ``[l * 16]`` int32: the triangles of each leaf, or -1.
        depth: the greatest number of nodes above a leaf.
    """

    boxes: npt.NDArray[np.float32]
    children: npt.NDArray[np.int32]
    corners: npt.NDArray[np.float32]
    members: npt.NDArray[np.int32]
    depth: int


def build_tree(vertices: npt.NDArray[np.float32], triangles: Triangles) -> RayTree:
    """Return the tree over ``triangles`` ``[t, 3]`` between ``vertices`` ``[v, 3]``.

    Triangles with a corner that is not finite lie nowhere.
    """
    first, second, third = (np.asarray(vertices, np.float32)[triangles[:, k]] for k in range(3))
    low = np.minimum(np.minimum(first, second), third)
    high = np.maximum(np.maximum(first, second), third)
    kept = np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1)
    extent = (high[kept].max(axis=0) - low[kept].min(axis=0)).max() if kept.any() else 0.0
    margin = np.float32(_MARGIN * extent)
    boxes, children, members, depth = _build(low - margin, high + margin, np.flatnonzero(kept).astype(np.int32))
    place = np.maximum(members, 0)
    placed = np.concatenate([first[place], second[place], third[place]], axis=1)
    placed[members < 0] = 0
    corners = placed.reshape(-1, LANES, 9).transpose(0, 2, 1)
    return RayTree(boxes, children, np.ascontiguousarray(corners).reshape(-1), members, depth)


@kernel
def _build(low: Floats, high: Floats, order: Integers) -> tuple[Floats, Integers, Integers, int]:
    """Return ``RayTree``'s boxes, children, members and depth of the triangles ``order``, which it sorts."""
    count = len(order)
    boxes = np.empty((max(count, 1), 6, LANES), np.float32)
    children = np.zeros((max(count, 1), LANES), np.int32)
    members = np.full((max(count, 1), LANES), -1, np.int32)
    waiting = [(0, 0, count, 1)]
    nodes, leaves, depth = 1, 0, 1
    starts, ends, areas = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64), np.zeros(LANES)
    while len(waiting) > 0:
        node, starts[0], ends[0], level = waiting.pop()
        depth = max(depth, level)
        parts = _divide(low, high, order, starts, ends, areas)
        boxes[node, :3], boxes[node, 3:] = np.inf, -np.inf
        for k in range(parts):
            start, end = starts[k], ends[k]
            _surround(low, high, order[start:end], boxes[node, :, k])
            if end - start > LANES:
                children[node, k] = nodes
                waiting.append((nodes, start, end, level + 1))
                nodes += 1
            else:
                children[node, k] = -1 - leaves
                members[leaves, : end - start] = order[start:end]
                leaves += 1
    flat = boxes[:nodes].copy().reshape(-1), children[:nodes].copy().reshape(-1), members[:leaves].copy().reshape(-1)
    return flat[0], flat[1], flat[2], depth


@kernel
def _divide(low: Floats, high: Floats, order: Integers, starts: Integers, ends: Integers, areas: Floats) -> int:
    """Divide a part of ``order``, the first of ``starts`` and ``ends``, into up to sixteen; return how many.

    The part that the most rays would have to search, by its surface and its triangles, is split next.
    """
    parts = 1 if ends[0] > starts[0] else 0
    box = np.empty(6, np.float32)
    areas[0] = np.inf
    while 0 < parts < LANES:
        worst, cost = -1, -1.0
        for k in range(parts):
            size = ends[k] - starts[k]
            if size > LANES and areas[k] * size > cost:
                worst, cost = k, areas[k] * size
        if worst < 0:
            break
        middle = _split(low, high, order[starts[worst] : ends[worst]]) + starts[worst]
        starts[parts], ends[parts], ends[worst] = middle, ends[worst], middle
        for k in (worst, parts):
            _surround(low, high, order[starts[k] : ends[k]], box)
            areas[k] = _area(box)
        parts += 1
    return parts


@kernel
def _split(low: Floats, high: Floats, order: Integers) -> int:
    """Sort ``order`` into two parts and return where the second begins."""
    best, axis, border, least, scale = np.inf, -1, 0, 0.0, 0.0
    boxes, counts = np.empty((_BINS, 6), np.float32), np.empty(_BINS, np.int64)
    for k in range(3):
        smallest, largest = np.inf, -np.inf
        for triangle in order:
            centre = np.float64(low[triangle, k]) + high[triangle, k]
            smallest, largest = min(smallest, centre), max(largest, centre)
        if largest <= smallest:
            continue
        factor = _BINS / (largest - smallest)
        boxes[:, :3], boxes[:, 3:], counts[:] = np.inf, -np.inf, 0
        for triangle in order:
            place = _bin(low[triangle, k], high[triangle, k], smallest, factor)
            counts[place] += 1
            _include(boxes[place], low[triangle], high[triangle])
        found, first_right = _cheapest(boxes, counts)
        if found < best:
            best, axis, border, least, scale = found, k, first_right, smallest, factor
    if axis < 0:  # all centres are one point
        return len(order) // 2
    first, last = 0, len(order) - 1
    while first <= last:
        if _bin(low[order[first], axis], high[order[first], axis], least, scale) < border:
            first += 1
        else:
            order[first], order[last] = order[last], order[first]
            last -= 1
    return first


@inline
def _bin(low: float, high: float, smallest: float, factor: float) -> int:
    return min(int((np.float64(low) + high - smallest) * factor), _BINS - 1)


@kernel
def _cheapest(boxes: Floats, counts: Integers) -> tuple[float, int]:
    """Return the cost of the best border between bins with ``boxes`` ``[b, 6]``, and the first bin beyond it."""
    costs = np.zeros(_BINS)
    box = np.empty(6, np.float32)
    for backward in (False, True):
        box[:3], box[3:] = np.inf, -np.inf
        inside = 0
        for step in range(_BINS - 1):
            place = _BINS - 1 - step if backward else step
            border = place if backward else place + 1
            _include(box, boxes[place, :3], boxes[place, 3:])
            inside += counts[place]
            # Sixteen triangles cost as much as one.
            costs[border] += _area(box) * ((inside + LANES - 1) // LANES) if inside else np.inf
    best = 1
    for border in range(2, _BINS):
        if costs[border] < costs[best]:
            best = border
    return costs[best], best


@inline
def _include(box: Floats, low: Floats, high: Floats) -> None:
    for k in range(3):
        box[k] = min(box[k], low[k])
        box[3 + k] = max(box[3 + k], high[k])


@kernel
def _surround(low: Floats, high: Floats, order: Integers, box: Floats) -> None:
    """Set ``box`` to the lower and the upper corner of all triangles ``order``."""
    box[:3], box[3:] = np.inf, -np.inf
    for triangle in order:
        _include(box, low[triangle], high[triangle])


@inline
def _area(box: Floats) -> float:
    x, y, z = np.float64(box[3]) - box[0], np.float64(box[4]) - box[1], np.float64(box[5]) - box[2]
    return float(x * y + y * z + z * x)
