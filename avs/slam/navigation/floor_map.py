"""The floor that a robot can stand on, found in the mesh of a building: several storeys, stairs, islands."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from avs.datasets.embedded.geometry.raycast import Caster
from avs.slam.building.building_mesh import FloatArray
from avs.slam.building.robot_camera import Pose
from avs.slam.navigation.agent_settings import AgentSettings
from avs.system.errors import UserError

_LAYERS = 24
_BELOW = 0.01
_STEEPEST = math.cos(math.radians(45))
_ROOFED = 0.5
_MOST_COLUMNS = 10_000_000


@dataclass(frozen=True)
class FloorMap:
    """The places where a robot can stand, as layers over a grid of columns.

    A column may have several floors, one above another; which layer one is in says nothing.

    Attributes:
        heights: ``[layers, nx, ny]`` float32 height of the floor in metres, NaN where it cannot stand.
        islands: ``[layers, nx, ny]`` int32 number of the connected floor, from the largest, 0, on; -1 for none.
        origin: ``[2]`` the corner of the first cell.
        agent: the robot.
        notes: what a reader of results should know.
    """

    heights: FloatArray
    islands: npt.NDArray[np.int32]
    origin: npt.NDArray[np.float64]
    agent: AgentSettings
    notes: tuple[str, ...] = ()

    def area(self, island: int) -> float:
        """Return the area of an island in square metres, as seen from above."""
        return float(np.count_nonzero(self.islands == island)) * self.agent.cell**2

    def cells(self, points: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
        """Return the cells ``[..., 2]`` of points ``[..., 2]``, which may lie outside of the grid."""
        return np.floor((points - self.origin) / self.agent.cell).astype(np.int64)

    def floor_at(self, x: float, y: float, floor: float, climb: float | None = None) -> float | None:
        """Return the height at (x, y) of the floor that can be stepped on from height ``floor``; None if there is none.

        ``climb`` is the greatest difference, by default the robot's step.
        """
        column, row = self.cells(np.array([x, y]))
        if not (0 <= column < self.heights.shape[1] and 0 <= row < self.heights.shape[2]):
            return None
        heights = self.heights[:, column, row]
        apart = np.where(np.isnan(heights), np.inf, np.abs(heights - floor))
        best = int(np.argmin(apart))
        limit = self.agent.step if climb is None else climb
        return float(heights[best]) if apart[best] <= limit + 1e-4 else None

    def storey(self, pose: Pose, span: float = 0.5) -> npt.NDArray[np.bool_]:
        """Return where, ``[layers, nx, ny]``, the floor belongs to the storey and island of ``pose``.

        The storey is what can be reached without leaving the heights within ``span`` of where the robot stands.

        Raises:
            UserError: the robot does not stand on the floor at ``pose``, or on an island that is too small.
        """
        floor = self.floor_at(pose.x, pose.y, pose.floor)
        if floor is None:
            place = f"start pose ({pose.x:.2f}, {pose.y:.2f}, {pose.floor:.2f})"
            raise UserError(place, f"is not on the floor: {self._what_is_at(pose)}", f"choose one, {self.example()}")
        near = np.abs(self.heights - floor) <= span
        numbers, _ = _islands(np.where(near, self.heights, np.nan), self.agent.step)
        column, row = self.cells(np.array([pose.x, pose.y]))
        layer = int(np.nanargmin(np.abs(self.heights[:, column, row] - floor)))
        storey = numbers == numbers[layer, column, row]
        area = float(np.count_nonzero(storey)) * self.agent.cell**2
        if area < self.agent.least_island:
            place = f"start pose ({pose.x:.2f}, {pose.y:.2f}, {pose.floor:.2f})"
            raise UserError(
                place, f"lies on an island of {area:.2f} square metres", f"choose another, {self.example()}"
            )
        return np.asarray(storey)

    def example(self) -> str:
        """Return a place in the middle of the largest island in words."""
        layer, column, row = (int(each[len(each) // 2]) for each in np.nonzero(self.islands == 0))
        x, y = self.origin + (np.array([column, row]) + 0.5) * self.agent.cell
        return f"such as ({x:.2f}, {y:.2f}, {self.heights[layer, column, row]:.2f})"

    def _what_is_at(self, pose: Pose) -> str:
        anywhere = self.floor_at(pose.x, pose.y, pose.floor, np.inf)
        if anywhere is None:
            return "there is a wall, furniture or nothing"
        return f"the floor there is at {anywhere:.2f} m"


def find_floor(caster: Caster, box: tuple[FloatArray, FloatArray], agent: AgentSettings, subject: object) -> FloorMap:
    """Return the floor of a building.

    A floor is a surface that is not steeper than 45 degrees with room for the robot above it: nothing within the height
    of its body straight above, and nothing nearer than its radius to its axis from its step upwards. Floors of
    neighbouring cells are connected where they differ by no more than its step. An island more than half of which has
    nothing above it is a roof or a garden, and left out, unless there is nothing else.

    Args:
        caster: of the mesh, metres, z upwards.
        box: the mesh's least and greatest coordinates.
        agent: the robot.
        subject: what an error names.

    Raises:
        UserError: the robot can stand nowhere, or the mesh is too wide to be searched.
    """
    low, high = (np.asarray(corner, np.float64) for corner in box)
    counts = np.maximum(np.ceil((high - low)[:2] / agent.cell).astype(int), 1)
    if counts.prod() > _MOST_COLUMNS:
        wide = " x ".join(f"{length:.0f}" for length in (high - low)[:2])
        fault = f"is {wide} m wide, more than {_MOST_COLUMNS:,} cells of the map of the floor"
        raise UserError(subject, fault, "remove stray triangles, check its unit (metres), or raise agent.cell")
    centres = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in counts), indexing="ij"), -1) * agent.cell + low[:2]
    heights, roofed = _surfaces(caster, centres.reshape(-1, 2), float(high[2]), agent)
    heights, roofed = _standing(caster, centres.reshape(-1, 2), heights, agent), roofed & ~np.isnan(heights)
    shape = (len(heights), *counts)
    heights, roofed = heights.reshape(shape), roofed.reshape(shape)
    islands, count = _islands(heights, agent.step)
    if not count:
        raise UserError(
            subject,
            f"has no floor on which a robot {agent.height} m high, {agent.radius} m in radius can stand",
            "check its axes and unit (up, metres), or make the robot smaller (agent)",
        )
    return _kept(FloorMap(heights, islands, low[:2], agent), roofed)


def _kept(found: FloorMap, roofed: npt.NDArray[np.bool_]) -> FloorMap:
    """Return the map without islands in the open, unless all are."""
    members = found.islands[found.islands >= 0]
    sizes = np.bincount(members)
    shares = np.bincount(found.islands[roofed & (found.islands >= 0)], minlength=len(sizes)) / sizes
    inside = shares >= _ROOFED
    if not inside.any():
        return FloorMap(
            found.heights, found.islands, found.origin, found.agent, ("no floor has a ceiling: open floors are kept",)
        )
    numbers = np.full(len(sizes) + 1, -1, np.int32)  # the last is that of -1
    numbers[:-1][inside] = np.arange(np.count_nonzero(inside))
    islands = numbers[found.islands]
    return FloorMap(np.where(islands >= 0, found.heights, np.nan), islands, found.origin, found.agent)


def _surfaces(
    caster: Caster, columns: npt.NDArray[np.float64], top: float, agent: AgentSettings
) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    """Return the heights ``[layers, n]`` of flat surfaces below which n columns go, and whether something is above.

    A surface that has another one above it within the height of the robot is none.
    """
    below = np.full(len(columns), top + 1.0, np.float32)
    above = np.full(len(columns), np.inf, np.float32)
    heights, roofed = [], []
    down = np.tile(np.array([0, 0, -1], np.float32), (len(columns), 1))
    for _ in range(_LAYERS):
        origins = np.concatenate([columns, below[:, None]], axis=1).astype(np.float32)
        hits = caster.nearest(origins, down)
        hit = hits.triangle >= 0
        if not hit.any():
            break
        height = np.where(hit, below - hits.distance, -np.inf).astype(np.float32)
        flat = hit & (caster.steepness(hits.triangle) >= _STEEPEST)
        heights.append(np.where(flat & (above - height >= agent.height), height, np.nan).astype(np.float32))
        roofed.append(np.isfinite(above))
        above = np.where(hit, height, above).astype(np.float32)
        below = np.where(hit, height - np.float32(_BELOW), -np.inf).astype(np.float32)
        below[~hit] = -1e6  # nothing is met from there
    if not heights:
        return np.full((1, len(columns)), np.nan, np.float32), np.zeros((1, len(columns)), bool)
    return np.stack(heights), np.stack(roofed)


def _standing(
    caster: Caster, columns: npt.NDArray[np.float64], heights: FloatArray, agent: AgentSettings
) -> FloatArray:
    """Return ``heights`` with NaN where the robot's body would touch something."""
    layer, column = np.nonzero(~np.isnan(heights))
    floor = heights[layer, column]
    low, high = agent.step + agent.radius, max(agent.height - agent.radius, agent.step + agent.radius)
    free = np.ones(len(floor), bool)
    for above in np.linspace(low, high, max(2, math.ceil((high - low) / agent.radius) + 1)):
        rows = np.flatnonzero(free)
        points = np.concatenate([columns[column[rows]], (floor[rows] + above)[:, None]], axis=1)
        free[rows] = caster.clearance(points.astype(np.float32)) >= agent.radius
    kept = np.full_like(heights, np.nan)
    kept[layer[free], column[free]] = floor[free]
    return kept


def _islands(heights: FloatArray, step: float) -> tuple[npt.NDArray[np.int32], int]:
    """Return the number ``[layers, nx, ny]`` of each floor's island, the largest first, and how many there are."""
    number = np.full(heights.shape, -1, np.int64)
    standing = ~np.isnan(heights)
    number[standing] = np.arange(np.count_nonzero(standing))
    ends: list[npt.NDArray[np.int64]] = []
    for upper in range(len(heights)):
        for lower in range(len(heights)):
            for a, b in ((np.s_[:-1, :], np.s_[1:, :]), (np.s_[:, :-1], np.s_[:, 1:])):
                first, second = heights[upper][a], heights[lower][b]
                with np.errstate(invalid="ignore"):
                    joined = np.abs(first - second) <= step + 1e-4
                ends.append(np.stack([number[upper][a][joined], number[lower][b][joined]]))
    edges = np.concatenate(ends, axis=1)
    size = int(np.count_nonzero(standing))
    if not size:
        return np.full(heights.shape, -1, np.int32), 0
    graph = coo_matrix((np.ones(edges.shape[1], bool), (edges[0], edges[1])), shape=(size, size))
    count, labels = connected_components(graph, directed=False)
    order = np.argsort(-np.bincount(labels), kind="stable")
    rank = np.empty(count, np.int32)
    rank[order] = np.arange(count)
    islands = np.full(heights.shape, -1, np.int32)
    islands[standing] = rank[labels]
    return islands, count
