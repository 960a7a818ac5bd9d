"""Shortest paths on a grid of cells: A*, distances to all cells, and lines of free sight."""

from __future__ import annotations

import heapq

import numpy as np
import numpy.typing as npt

from avs.rasterizer.kernels import Floats, Integers, kernel

Grid = npt.NDArray[np.bool_]
Cells = npt.NDArray[np.int64]

# Sixteen moves: to the eight neighbours, and by a knight's move. Those beyond the neighbours lead over two cells, both
# of which must be free.
_MOVES = np.array(
    [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)]
    + [(a * x, b * y) for x, y in ((1, 2), (2, 1)) for a in (1, -1) for b in (1, -1)],
    np.int64,
)


def shortest_path(free: Grid, cost: npt.NDArray[np.float32], start: Cells, goal: Cells) -> Cells | None:
    """Return the cells ``[k, 2]`` of the cheapest path from ``start`` to ``goal``, both included, or None.

    A* with sixteen directions. A move costs its length in cells times one plus the ``cost`` of the cell that it leads
    to. Ties go to the cell that was found first, so that equal grids give equal paths.

    Args:
        free: ``[nx, ny]`` cells that may be entered; the start may be taken in any case.
        cost: ``[nx, ny]`` what is added to the cost per cell, at least 0.
        start: ``[2]``.
        goal: ``[2]``.
    """
    if not free[tuple(goal)]:
        return None
    came = _search(free, cost.astype(np.float32), start, goal, _MOVES)[1]
    if came[tuple(goal)] < 0 and tuple(goal) != tuple(start):
        return None
    path = [np.asarray(goal, np.int64)]
    while tuple(path[-1]) != tuple(start):
        path.append(path[-1] - _MOVES[came[tuple(path[-1])]])
    return np.array(path[::-1])


def travel_costs(free: Grid, cost: npt.NDArray[np.float32], start: Cells) -> npt.NDArray[np.float64]:
    """Return the cost ``[nx, ny]`` of the cheapest path to each cell, infinite where there is none."""
    nowhere = np.array([-1, -1], np.int64)
    return np.asarray(_search(free, cost.astype(np.float32), start, nowhere, _MOVES)[0])


def straightened(free: Grid, path: Cells) -> Cells:
    """Return the corners of ``path`` ``[k, 2]``: each is seen from the one before it over free cells alone."""
    corners = [0]
    for place in range(2, len(path)):
        if not in_sight(free, path[corners[-1]], path[place]):
            corners.append(place - 1)
    if len(path) > 1:
        corners.append(len(path) - 1)
    return path[corners]


def in_sight(free: Grid, first: Cells, second: Cells) -> bool:
    """Return whether all cells that the line between two cells' centres passes are free, in steps of a third of one."""
    count = int(np.ceil(3 * np.abs(second - first).max())) + 1
    shares = np.linspace(0, 1, count)[1:, None]
    passed = np.floor(first + 0.5 + shares * (second - first)).astype(np.int64)
    return bool(free[passed[:, 0], passed[:, 1]].all())


# Long because a compiled function that is called for every move would cost more than what it parts.
@kernel
def _search(
    free: Integers, cost: Floats, start: Integers, goal: Integers, moves: Integers
) -> tuple[Floats, Integers]:  # fmt: skip
    """Return the costs from ``start``, and the move that led to each cell (-1: none); ends at a ``goal`` >= 0."""
    nx, ny = free.shape
    costs = np.full((nx, ny), np.inf)
    came = np.full((nx, ny), -1, np.int64)
    closed = np.zeros((nx, ny), np.bool_)
    guided = goal[0] >= 0
    costs[start[0], start[1]] = 0.0
    heap = [(0.0, np.int64(0), np.int64(start[0]), np.int64(start[1]))]
    pushed = np.int64(0)
    while len(heap):
        _, _, x, y = heapq.heappop(heap)
        if closed[x, y]:
            continue
        closed[x, y] = True
        if guided and x == goal[0] and y == goal[1]:
            break
        for m in range(len(moves)):
            dx, dy = moves[m, 0], moves[m, 1]
            i, j = x + dx, y + dy
            if i < 0 or j < 0 or i >= nx or j >= ny or not free[i, j] or closed[i, j]:
                continue
            if abs(dx) + abs(dy) == 2:
                if not (free[x + dx, y] and free[x, y + dy]):
                    continue
            elif abs(dx) + abs(dy) == 3:
                # the two cells beside the middle of the move
                first_free = free[x + (dx // 2 if abs(dx) == 2 else 0), y + (dy // 2 if abs(dy) == 2 else 0)]
                second_free = free[i - (dx // 2 if abs(dx) == 2 else 0), j - (dy // 2 if abs(dy) == 2 else 0)]
                if not (first_free and second_free):
                    continue
            length = np.sqrt(np.float64(dx * dx + dy * dy))
            total = costs[x, y] + length * (1.0 + cost[i, j])
            if total < costs[i, j]:
                costs[i, j] = total
                came[i, j] = m
                pushed += 1
                ahead = 0.0
                if guided:
                    ahead = np.sqrt(np.float64((goal[0] - i) ** 2 + (goal[1] - j) ** 2))
                heapq.heappush(heap, (total + ahead, pushed, i, j))
    return costs, came
