"""Points of a building's surface that can be seen from where the robot can be, and which of them were seen."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras
from avs.slam.building.robot_camera import CameraSettings
from avs.slam.building.simulator import Simulator
from avs.slam.navigation.floor_map import FloorMap

FloatArray = npt.NDArray[np.float64]

_TOLERANCE = 0.01


def surface_samples(simulator: Simulator, count: int, rng: np.random.Generator) -> FloatArray:
    """Return ``count`` points ``[count, 3]`` drawn uniformly over the surface of a building, by area."""
    building = simulator.building
    a, b, c = (building.vertices[building.triangles[:, k]].astype(np.float64) for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = np.searchsorted(np.cumsum(areas), rng.random(count) * areas.sum(), side="right").clip(0, len(areas) - 1)
    root, second = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
    weights = np.concatenate([1 - root, root * (1 - second), root * second], axis=1)
    return np.asarray(np.einsum("nk,knc->nc", weights, np.stack([a[chosen], b[chosen], c[chosen]])))


def visible_from_floor(
    simulator: Simulator,
    floor_map: FloorMap,
    where: npt.NDArray[np.bool_],
    camera: CameraSettings,
    points: FloatArray,
    spacing: float,
) -> npt.NDArray[np.bool_]:
    """Return which ``points`` ``[n, 3]`` a robot could see from the part ``where`` of the floor.

    It stands on every place of a lattice, at any direction, its camera level: a point counts where nothing lies between
    it and the camera but the last centimetre, and it is no farther above or below than the field of view allows. Both
    sides of a surface count.

    Args:
        simulator: the building.
        floor_map: its floor.
        where: ``[layers, nx, ny]``.
        camera: of the robot.
        points: on the surface.
        spacing: of the lattice, metres.
    """
    steepest = np.tan(np.radians(camera.field_of_view) / 2) * camera.height / camera.width
    visible = np.zeros(len(points), bool)
    for centre in _viewpoints(floor_map, where, camera, spacing):
        left = np.flatnonzero(~visible)
        offsets = points[left] - centre
        aside = np.linalg.norm(offsets[:, :2], axis=1)
        shown = np.abs(offsets[:, 2]) <= steepest * aside
        left, offsets = left[shown], offsets[shown]
        length = np.linalg.norm(offsets, axis=1, keepdims=True)
        rays = offsets * np.maximum(1 - _TOLERANCE / np.maximum(length, 1e-9), 0)
        visible[left] = ~simulator.caster.blocked(centre.astype(np.float32), rays.astype(np.float32), 1.0)
    return visible


def _viewpoints(
    floor_map: FloorMap, where: npt.NDArray[np.bool_], camera: CameraSettings, spacing: float
) -> FloatArray:
    """Return places ``[k, 3]`` of the camera on a lattice over a part of the floor, at least one."""
    stride = max(1, round(spacing / floor_map.agent.cell))
    lattice = np.zeros_like(where)
    lattice[:, ::stride, ::stride] = True
    layers, columns, rows = np.nonzero(where & lattice)
    if not len(layers):
        layers, columns, rows = (each[:1] for each in np.nonzero(where))
    plane = floor_map.origin + (np.stack([columns, rows], axis=1) + 0.5) * floor_map.agent.cell
    heights = floor_map.heights[layers, columns, rows] + camera.above_floor
    return np.concatenate([plane, heights[:, None]], axis=1)


class SeenSurface:
    """Points of the surface, and which of them the robot's depth camera has seen.

    Attributes:
        points: ``[n, 3]`` metres.
        seen: ``[n]`` which were seen so far.
    """

    def __init__(self, points: FloatArray, simulator: Simulator, threshold: float) -> None:
        """Begin with nothing seen; a point is seen where depth agrees with it within ``threshold`` metres."""
        self.points = points
        self.seen = np.zeros(len(points), bool)
        self._simulator, self._threshold = simulator, threshold

    def look(self, camera: Cameras, depth: npt.NDArray[np.float32]) -> None:
        """Count what one picture shows, ``depth`` being its true depth ``[height, width]``."""
        self.seen |= self._shown(camera, depth)

    def new_from(self, camera: Cameras) -> int:
        """Return how many points would be seen for the first time from a camera."""
        return int(np.count_nonzero(self._shown(camera, self._simulator.depth(camera)) & ~self.seen))

    @property
    def share(self) -> float:
        """Share of the points that were seen, in 0..1."""
        return float(self.seen.mean()) if len(self.seen) else 0.0

    def _shown(self, camera: Cameras, depth: npt.NDArray[np.float32]) -> npt.NDArray[np.bool_]:
        pose, matrix = camera.world_to_camera[0], camera.intrinsics[0]
        local = self.points @ pose[:3, :3].T + pose[:3, 3]
        ahead = local[:, 2] > 1e-6
        plane = local[:, :2] / np.where(ahead, local[:, 2], 1)[:, None]
        pixels = np.floor(plane * matrix[[0, 1], [0, 1]] + matrix[:2, 2])
        inside = ahead & ((pixels >= 0) & (pixels < camera.sizes[0])).all(axis=1)
        shown = np.zeros(len(self.points), bool)
        columns, rows = pixels[inside].astype(int).T
        shown[inside] = np.abs(depth[rows, columns] - local[inside, 2]) < self._threshold
        return shown
