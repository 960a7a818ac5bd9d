"""A building ready to be explored: its floor, the storey of the start, and the surface that can be seen from there."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from avs.slam.building.opened_building import open_simulator
from avs.slam.building.robot_camera import Pose
from avs.slam.building.side_files import mesh_digest
from avs.slam.building.simulator import Simulator
from avs.slam.evaluation.seen_surface import surface_samples, visible_from_floor
from avs.slam.loop.slam_settings import SlamSettings
from avs.slam.navigation.floor_map import FloorMap, find_floor
from avs.slam.navigation.robot_motion import random_poses
from avs.system.errors import UserError
from avs.system.seeds import seed_of


@dataclass(frozen=True)
class World:
    """What a robot explores.

    Attributes:
        name: of the building.
        digest: SHA-256 of its file.
        simulator: what a camera sees in it.
        floor_map: where the robot can stand.
        storey: ``[layers, nx, ny]`` the part of the floor that can be reached on the storey of the start.
        start: the first pose.
        surface: ``[n, 3]`` points of the surface that can be seen from the storey, metres.
        poses: at which renderings are compared.
        notes: what a reader of results should know of the mesh.
    """

    name: str
    digest: str
    simulator: Simulator
    floor_map: FloorMap
    storey: npt.NDArray[np.bool_]
    start: Pose
    surface: npt.NDArray[np.float64]
    poses: tuple[Pose, ...]
    notes: tuple[str, ...]

    @property
    def floor_area(self) -> float:
        """Area of the storey in square metres."""
        return float(np.count_nonzero(self.storey)) * self.floor_map.agent.cell**2


def open_world(path: Path, name: str, settings: SlamSettings, seed: int) -> World:
    """Return a building ready to be explored.

    The points of the surface and the poses of the comparison depend on the building, the storey and the settings, not
    on ``seed``, which draws the start alone.

    Raises:
        UserError: the mesh cannot be read, has no floor, the start is not on it, or nothing can be seen from it.
    """
    simulator = open_simulator(path, settings.simulator)
    floor_map = find_floor(simulator.caster, simulator.building.box, settings.agent, path)
    start = _start(floor_map, settings, seed, path)
    storey = floor_map.storey(start)
    evaluation = settings.evaluation
    rng = np.random.default_rng(seed_of("slam evaluation", evaluation.seed))
    samples = surface_samples(simulator, evaluation.points, rng)
    seen = visible_from_floor(simulator, floor_map, storey, settings.camera, samples, evaluation.spacing)
    if not seen.any():
        fault = "shows no surface to a level camera on its floor, so that nothing can be covered"
        raise UserError(path, fault, "check camera.above_floor and camera.field_of_view")
    poses = random_poses(floor_map, storey, evaluation.poses, rng)
    notes = (*simulator.building.notes, *floor_map.notes, *_beyond_the_grid(floor_map, storey, start, settings))
    return World(
        name, mesh_digest(path), simulator, floor_map, storey, start, samples[seen], tuple(poses), notes
    )  # fmt: skip


def _beyond_the_grid(
    floor_map: FloorMap, storey: npt.NDArray[np.bool_], start: Pose, settings: SlamSettings
) -> tuple[str, ...]:
    """Return what to say where the robot's grid, with the start in its middle, does not hold the whole storey."""
    occupancy = settings.exploration.occupancy
    half = occupancy.cells * occupancy.cell / 2
    columns, rows = np.nonzero(storey.any(axis=0))
    centres = floor_map.origin + (np.stack([columns, rows], axis=1) + 0.5) * floor_map.agent.cell
    share = float((np.abs(centres - (start.x, start.y)) > half).any(axis=1).mean())
    if not share:
        return ()
    told = f"{100 * share:.2g} % of the floor lies beyond the robot's grid of {2 * half:g} m around its start"
    return (f"{told}, which can never be chosen; raise exploration.occupancy.cells",)


def _start(floor_map: FloorMap, settings: SlamSettings, seed: int, path: Path) -> Pose:
    if settings.start is not None:
        x, y, floor, degrees = settings.start
        height = floor_map.floor_at(x, y, floor)
        return Pose(x, y, floor if height is None else height, math.radians(degrees))
    if floor_map.area(0) < settings.agent.least_island:
        fault = f"its largest floor has {floor_map.area(0):.2f} square metres"
        raise UserError(path, fault, "check its axes and unit (up, metres), or lower agent.least_island")
    rng = np.random.default_rng(seed_of("slam start", seed))
    return random_poses(floor_map, floor_map.islands == 0, 1, rng)[0]
