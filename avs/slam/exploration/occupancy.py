"""What a robot knows of the floor: a grid of unknown, occupied and free cells, voted from depth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from avs.rasterizer.kernels import Floats, Integers, kernel
from avs.scene.cameras import Cameras
from avs.slam.building.robot_camera import Pose
from avs.slam.exploration.exploration_settings import OccupancySettings
from avs.slam.navigation.grid_paths import Grid

_NEIGHBOURS = np.ones((3, 3), bool)


@dataclass(frozen=True)
class Occupancy:
    """Votes of depth images on the cells of a grid; the arrays change as the robot goes on.

    A frame votes once on each cell that it sees: occupied if a point between ``low`` and ``high`` above the floor lies
    there, else free if a ray passes between these heights or ends below them.

    Attributes:
        occupied: ``[n, n]`` int32 votes.
        free: ``[n, n]`` int32 votes.
        blocked: ``[n, n]`` cells where the robot has met something that it did not see.
        origin: ``[2]`` the corner of the first cell, metres.
        settings: of the grid.
    """

    occupied: npt.NDArray[np.int32]
    free: npt.NDArray[np.int32]
    blocked: Grid
    origin: npt.NDArray[np.float64]
    settings: OccupancySettings

    def cell_of(self, x: float, y: float) -> npt.NDArray[np.int64]:
        """Return the cell ``[2]`` of a point, held inside the grid."""
        cell = np.floor((np.array([x, y]) - self.origin) / self.settings.cell).astype(np.int64)
        return np.asarray(np.clip(cell, 0, self.settings.cells - 1), np.int64)

    def centres(self, cells: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        """Return the points ``[k, 2]`` in the middle of ``cells`` ``[k, 2]``, metres."""
        return self.origin + (cells + 0.5) * self.settings.cell

    @property
    def unknown(self) -> Grid:
        """``[n, n]`` cells without any vote."""
        return np.asarray((self.occupied == 0) & (self.free == 0))


def empty_occupancy(start: Pose, settings: OccupancySettings) -> Occupancy:
    """Return a grid of unknown cells with ``start`` in its middle."""
    shape = (settings.cells, settings.cells)
    origin = np.array([start.x, start.y]) - settings.cells * settings.cell / 2
    return Occupancy(np.zeros(shape, np.int32), np.zeros(shape, np.int32), np.zeros(shape, bool), origin, settings)


def vote(grid: Occupancy, depth: npt.NDArray[np.float32], camera: Cameras, pose: Pose, radius: float) -> None:
    """Add the votes of one depth image ``[height, width]``; what the robot stands on is free."""
    settings = grid.settings
    seen = np.zeros(grid.free.shape, np.uint8)
    matrix, view = camera.intrinsics[0], camera.world_to_camera[0]
    centre = camera.centers[0] - np.array([*grid.origin, pose.floor])
    _mark(
        depth, np.linalg.inv(matrix), np.ascontiguousarray(view[:3, :3]), centre, settings.cell, settings.reach,
        settings.low, settings.high, seen,
    )  # fmt: skip
    reach = math.ceil(radius / settings.cell)
    column, row = grid.cell_of(pose.x, pose.y)
    around = seen[max(column - reach, 0) : column + reach + 1, max(row - reach, 0) : row + reach + 1]
    around[around == 0] = 1
    _count(seen, grid.free, grid.occupied)


@kernel
def _count(seen: Integers, free: Integers, occupied: Integers) -> None:
    """Add one vote for each cell that was seen: 1 is free, 2 occupied."""
    for i in range(seen.shape[0]):
        for j in range(seen.shape[1]):
            if seen[i, j] == 1:
                free[i, j] += 1
            elif seen[i, j] == 2:
                occupied[i, j] += 1


@kernel
def _mark(
    depth: Floats, inverse: Floats, rotation: Floats, centre: Floats, cell: float, reach: float, low: float,
    high: float, seen: Integers,
) -> None:  # fmt: skip
    """Set cells of ``seen`` to 1 where rays pass or end on the floor, to 2 where they end on an obstacle."""
    height, width = depth.shape
    columns, rows = seen.shape
    for v in range(height):
        for u in range(width):
            far = np.float64(depth[v, u])
            if far <= 0.0 or far > reach:
                continue
            x = inverse[0, 0] * (u + 0.5) + inverse[0, 2]
            y = inverse[1, 1] * (v + 0.5) + inverse[1, 2]
            dx = (rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0]) * far
            dy = (rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1]) * far
            dz = (rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2]) * far
            count = int(np.ceil(max(abs(dx), abs(dy)) / cell)) + 1
            for k in range(count + 1):
                share = k / count
                z = centre[2] + share * dz
                i = int(np.floor((centre[0] + share * dx) / cell))
                j = int(np.floor((centre[1] + share * dy) / cell))
                if i < 0 or j < 0 or i >= columns or j >= rows:
                    break
                if k == count:
                    if z >= low and z <= high:
                        seen[i, j] = 2
                    elif z < low and seen[i, j] == 0:
                        seen[i, j] = 1
                elif z >= low and z <= high and seen[i, j] == 0:
                    seen[i, j] = 1


def free_space(grid: Occupancy, means: npt.NDArray[np.float32], pose: Pose) -> Grid:
    """Return the free cells ``[n, n]`` that are connected to the robot.

    Cells that more frames found free than occupied, and where no more than ``gaussians`` of the map are, opened by 3x3
    cells; of these the component of the robot, or the largest where it stands on none.

    Args:
        grid: the votes.
        means: ``[m, 3]`` centres of the map's Gaussians.
        pose: of the robot.
    """
    settings = grid.settings
    free = (grid.free > grid.occupied) & ~grid.blocked
    if settings.gaussians is not None and len(means):
        above = means[:, 2] - pose.floor
        inside = means[(above >= settings.low) & (above <= settings.high), :2]
        cells = np.floor((inside - grid.origin) / settings.cell).astype(np.int64)
        cells = cells[((cells >= 0) & (cells < settings.cells)).all(axis=1)]
        counts = np.zeros(free.shape, np.int64)
        np.add.at(counts, (cells[:, 0], cells[:, 1]), 1)
        free &= counts <= settings.gaussians
    opened = ndimage.binary_opening(free, _NEIGHBOURS)
    labels, count = ndimage.label(opened, _NEIGHBOURS)
    if not count:
        return np.asarray(opened)
    own = labels[tuple(grid.cell_of(pose.x, pose.y))]
    return np.asarray(labels == (own or int(np.argmax(np.bincount(labels.ravel())[1:])) + 1))
