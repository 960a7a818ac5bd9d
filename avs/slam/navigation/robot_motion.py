"""The discrete actions of a robot, and what becomes of them where a wall is in the way; and poses drawn by chance."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from avs.slam.building.robot_camera import Pose
from avs.slam.navigation.agent_settings import MotionSettings
from avs.slam.navigation.floor_map import FloorMap

Action = Literal["forward", "left", "right"]

_SUB_STEP = 0.01
_SLIDES = tuple(math.radians(sign * angle) for angle in (15, 30, 45, 60, 75) for sign in (1, -1))


@dataclass(frozen=True)
class Moved:
    """The outcome of one action.

    Attributes:
        pose: where the robot is then.
        collided: whether something was in its way.
    """

    pose: Pose
    collided: bool


def move(floor_map: FloorMap, pose: Pose, action: Action, settings: MotionSettings) -> Moved:
    """Return what an action leads to.

    On its way forward the robot goes in steps of a centimetre. Where one would lead off the floor it slides: it takes
    the direction nearest to its own, up to 75 degrees aside, that leads on, by the part of the step that points there.
    """
    if action != "forward":
        turn = math.radians(settings.turn) * (1 if action == "left" else -1)
        return Moved(replace(pose, yaw=_wrapped(pose.yaw + turn)), False)
    collided, left = False, settings.forward
    while left > 1e-9:
        length = min(_SUB_STEP, left)
        ahead = _ahead(floor_map, pose, pose.yaw, length)
        if ahead is None:
            collided = True
            slides = (_ahead(floor_map, pose, pose.yaw + aside, length * math.cos(aside)) for aside in _SLIDES)
            ahead = next((found for found in slides if found is not None), None)
        if ahead is None:
            break
        pose, left = ahead, left - length
    return Moved(pose, collided)


def random_poses(floor_map: FloorMap, where: npt.NDArray[np.bool_], count: int, rng: np.random.Generator) -> list[Pose]:
    """Return poses drawn uniformly over the floor, with uniform directions.

    Args:
        floor_map: the floor.
        where: ``[layers, nx, ny]`` the part of it to draw from, not empty.
        count: how many.
        rng: of the draws.
    """
    layers, columns, rows = np.nonzero(where)
    chosen = rng.integers(len(layers), size=count)
    offsets, yaws = rng.random((count, 2)), rng.uniform(-math.pi, math.pi, count)
    points = floor_map.origin + (np.stack([columns, rows], 1)[chosen] + offsets) * floor_map.agent.cell
    heights = floor_map.heights[layers[chosen], columns[chosen], rows[chosen]]
    return [
        Pose(float(x), float(y), float(z), float(yaw)) for (x, y), z, yaw in zip(points, heights, yaws, strict=True)
    ]


def _ahead(floor_map: FloorMap, pose: Pose, direction: float, length: float) -> Pose | None:
    x, y = pose.x + length * math.cos(direction), pose.y + length * math.sin(direction)
    floor = floor_map.floor_at(x, y, pose.floor)
    return None if floor is None else replace(pose, x=x, y=y, floor=floor)


def _wrapped(angle: float) -> float:
    """Return the angle in -pi..pi."""
    return math.remainder(angle, 2 * math.pi)
