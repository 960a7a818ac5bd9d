"""Frontiers between free and unknown floor (Yamauchi 1997), and poses from which they can be looked at."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from avs.slam.building.robot_camera import Pose
from avs.slam.exploration.exploration_settings import FrontierSettings
from avs.slam.exploration.occupancy import Occupancy
from avs.slam.navigation.grid_paths import Grid

_NEIGHBOURS = np.ones((3, 3), bool)


@dataclass(frozen=True)
class Frontier:
    """A connected border of the free floor with the unknown.

    Attributes:
        cells: ``[k, 2]`` cells.
        centroid: ``[2]`` metres.
        merit: its size over its mean distance to the robot plus a constant, in cells.
    """

    cells: npt.NDArray[np.int64]
    centroid: npt.NDArray[np.float64]
    merit: float


@dataclass(frozen=True)
class Candidate:
    """A pose to go to.

    Attributes:
        pose: where, and in which direction to look.
        frontier: index of the frontier that it looks at; -1 where there is none.
    """

    pose: Pose
    frontier: int


def frontiers(grid: Occupancy, free: Grid, pose: Pose, settings: FrontierSettings) -> list[Frontier]:
    """Return the frontiers of ``free`` ``[n, n]``, the best first, ties by their first cell.

    A frontier is a component, also across corners, of the unknown cells next to a free one.
    """
    edge = ndimage.binary_dilation(free, _NEIGHBOURS) & ~free & grid.unknown
    labels, count = ndimage.label(edge, _NEIGHBOURS)
    robot = grid.cell_of(pose.x, pose.y)
    found = []
    for place, part in enumerate(ndimage.find_objects(labels), start=1):
        cells = np.argwhere(labels[part] == place) + [axis.start for axis in part]
        if len(cells) < settings.least:
            continue
        distance = np.linalg.norm(cells - robot, axis=1).mean()
        merit = len(cells) / (float(distance) + settings.far)
        found.append(Frontier(cells, grid.centres(cells).mean(axis=0), merit))
    assert count >= len(found)
    return sorted(found, key=lambda frontier: -frontier.merit)


def eroded(free: Grid, cells: int) -> Grid:
    """Return the cells around which a square of ``cells`` a side is free."""
    return np.asarray(ndimage.binary_erosion(free, np.ones((cells, cells), bool)))


def candidates(
    grid: Occupancy,
    inner: Grid,
    borders: list[Frontier],
    pose: Pose,
    settings: FrontierSettings,
    rng: np.random.Generator,
) -> list[Candidate]:
    """Return poses that look at the best frontiers from an annulus around their centroids.

    Where no place in an annulus is free it grows. Without any frontier they are places by chance on the free floor,
    looking in directions by chance.

    Args:
        grid: what is known of the floor.
        inner: ``[n, n]`` where the robot can be, with room around it.
        borders: the frontiers, the best first.
        pose: of the robot.
        settings: how many, and from where.
        rng: of the draws.
    """
    chosen = borders[: settings.considered]
    if not chosen:
        return _anywhere(grid, inner, pose, settings.candidates, rng)
    found: list[Candidate] = []
    for index, frontier in enumerate(chosen):
        count = len(range(index, settings.candidates, len(chosen)))
        near, far = settings.nearest, settings.farthest
        for _ in range(settings.expansions + 1):
            around = _around(grid, inner, frontier, pose, (near, far), count, rng)
            if around:
                break
            near, far = near * settings.expansion, far * settings.expansion
        found += [Candidate(each, index) for each in around]
    return found


def _around(
    grid: Occupancy,
    inner: Grid,
    frontier: Frontier,
    pose: Pose,
    radii: tuple[float, float],
    count: int,
    rng: np.random.Generator,
) -> list[Pose]:
    """Return those of ``count`` poses in an annulus that are free, looking at its middle."""
    angles, lengths = rng.uniform(-math.pi, math.pi, count), rng.uniform(*radii, count)
    offsets = lengths[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = frontier.centroid + offsets
    cells = np.floor((places - grid.origin) / grid.settings.cell).astype(np.int64)
    inside = ((cells >= 0) & (cells < grid.settings.cells)).all(axis=1)
    inside[inside] = inner[cells[inside, 0], cells[inside, 1]]
    return [
        Pose(float(x), float(y), pose.floor, math.atan2(-dy, -dx))
        for (x, y), (dx, dy) in zip(places[inside], offsets[inside], strict=True)
    ]


def _anywhere(grid: Occupancy, inner: Grid, pose: Pose, count: int, rng: np.random.Generator) -> list[Candidate]:
    """Return poses on a quarter of the free places, by chance, at most ``count``."""
    cells = np.argwhere(inner)
    chosen = rng.permutation(len(cells))[: min(count, -(-len(cells) // 4))]
    yaws = rng.uniform(-math.pi, math.pi, len(chosen))
    return [
        Candidate(Pose(float(x), float(y), pose.floor, float(yaw)), -1)
        for (x, y), yaw in zip(grid.centres(cells[chosen]), yaws, strict=True)
    ]
