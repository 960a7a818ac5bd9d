"""Paths to candidates as actions of the robot, and the poses that it passes on them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from avs.slam.building.robot_camera import Pose
from avs.slam.exploration.exploration_settings import PathSettings
from avs.slam.exploration.frontiers import Candidate
from avs.slam.exploration.occupancy import Occupancy
from avs.slam.navigation.agent_settings import MotionSettings
from avs.slam.navigation.grid_paths import Grid, shortest_path, straightened
from avs.slam.navigation.robot_motion import Action


@dataclass(frozen=True)
class PlannedPath:
    """A way to a candidate.

    Attributes:
        candidate: its index.
        actions: of the robot, up to the horizon.
        poses: after each action, if nothing is in the way.
        length: of the whole way, metres.
    """

    candidate: int
    actions: tuple[Action, ...]
    poses: tuple[Pose, ...]
    length: float


def planned_paths(
    grid: Occupancy,
    free: Grid,
    inner: Grid,
    pose: Pose,
    wanted: Sequence[tuple[int, Candidate]],
    settings: PathSettings,
    motion: MotionSettings,
) -> list[PlannedPath]:
    """Return ways to the ``wanted`` candidates, by index, without those that cannot be reached or repeat another.

    Ways lead over ``inner``; a robot that stands outside of it, but on ``free`` floor, may leave by the latter.
    """
    start = grid.cell_of(pose.x, pose.y)
    walkable = inner | (free & _near(start, free.shape, 8)) if not inner[tuple(start)] else inner
    cost = obstacle_cost(free, grid.settings.cell, settings)
    found: dict[tuple[Action, ...], PlannedPath] = {}
    for index, candidate in wanted:
        cells = shortest_path(walkable, cost, start, grid.cell_of(candidate.pose.x, candidate.pose.y))
        if cells is None:
            continue
        corners = [*grid.centres(straightened(walkable, cells))[1:-1], (candidate.pose.x, candidate.pose.y)]
        actions, poses = followed(pose, np.array(corners), candidate.pose.yaw, motion)
        actions, poses = actions[: settings.horizon], poses[: settings.horizon]
        if actions:
            length = float(np.linalg.norm(np.diff(cells, axis=0), axis=1).sum()) * grid.settings.cell
            found.setdefault(tuple(actions), PlannedPath(index, tuple(actions), tuple(poses), length))
    return list(found.values())


def obstacle_cost(free: Grid, cell: float, settings: PathSettings) -> npt.NDArray[np.float32]:
    """Return what each cell costs more for being near an obstacle: linear, from ``clearance_cost`` there to 0."""
    if not settings.clearance:
        return np.zeros(free.shape, np.float32)
    distance = ndimage.distance_transform_edt(free) * cell
    return np.asarray(settings.clearance_cost * np.clip(1 - distance / settings.clearance, 0, 1), np.float32)


def followed(
    pose: Pose, corners: npt.NDArray[np.float64], yaw: float, motion: MotionSettings
) -> tuple[list[Action], list[Pose]]:
    """Return the actions that lead from ``pose`` over ``corners`` ``[k, 2]`` to the direction ``yaw``, and the poses.

    At each corner the robot turns towards the next as near as its turns allow, and again on the way once its direction
    is off by more than a turn; a corner is reached within a step.
    """
    actions: list[Action] = []
    poses: list[Pose] = []

    def turn_to(direction: float) -> None:
        nonlocal pose
        step = math.radians(motion.turn)
        turns = round(math.remainder(direction - pose.yaw, 2 * math.pi) / step)
        for _ in range(abs(turns)):
            pose = replace(pose, yaw=math.remainder(pose.yaw + math.copysign(step, turns), 2 * math.pi))
            actions.append("left" if turns > 0 else "right")
            poses.append(pose)

    for x, y in corners:
        while math.hypot(x - pose.x, y - pose.y) > motion.forward:
            direction = math.atan2(y - pose.y, x - pose.x)
            if abs(math.remainder(direction - pose.yaw, 2 * math.pi)) > math.radians(motion.turn):
                turn_to(direction)
            ahead = motion.forward * math.cos(pose.yaw), motion.forward * math.sin(pose.yaw)
            pose = replace(pose, x=pose.x + ahead[0], y=pose.y + ahead[1])
            actions.append("forward")
            poses.append(pose)
    turn_to(yaw)
    return actions, poses


def _near(cell: npt.NDArray[np.int64], shape: tuple[int, ...], reach: int) -> Grid:
    near = np.zeros(shape, bool)
    near[tuple(slice(max(place - reach, 0), place + reach + 1) for place in cell)] = True
    return near
