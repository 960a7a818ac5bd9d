"""The camera of a robot that stands on a floor and looks straight ahead."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import Field, PositiveFloat, PositiveInt

from avs.scene.cameras import Cameras, FloatArray, concatenate
from avs.system.models import StrictModel


class CameraSettings(StrictModel):
    """A pinhole camera on a robot."""

    width: PositiveInt = Field(default=800, description="image width in pixels (FisherRF's mapping: 800)")
    height: PositiveInt = Field(default=800, description="image height in pixels (FisherRF's mapping: 800)")
    field_of_view: float = Field(default=90.0, gt=1, lt=170, description="horizontal, in degrees")
    above_floor: PositiveFloat = Field(default=1.25, description="height of its centre above the floor in metres")


@dataclass(frozen=True)
class Pose:
    """Where a robot stands.

    Attributes:
        x: metres.
        y: metres.
        floor: height of the floor under it, metres.
        yaw: direction of view in radians, from x towards y.
    """

    x: float
    y: float
    floor: float
    yaw: float

    @property
    def place(self) -> FloatArray:
        """``[3]`` the point of the floor."""
        return np.array([self.x, self.y, self.floor])


def camera_at(pose: Pose, settings: CameraSettings) -> Cameras:
    """Return the camera, a batch of one, of a robot at ``pose``.

    Raises:
        ValueError: the pose holds a number that is not finite.
    """
    numbers = (pose.x, pose.y, pose.floor, pose.yaw)
    if not all(map(math.isfinite, numbers)):
        raise ValueError(f"a pose needs finite numbers, not {numbers}")
    cosine, sine = math.cos(pose.yaw), math.sin(pose.yaw)
    rotation = np.array([[sine, -cosine, 0.0], [0.0, 0.0, -1.0], [cosine, sine, 0.0]])
    transform = np.eye(4)
    transform[:3, :3] = rotation
    transform[:3, 3] = -rotation @ np.array([pose.x, pose.y, pose.floor + settings.above_floor])
    focal = settings.width / 2 / math.tan(math.radians(settings.field_of_view) / 2)
    matrix = np.array([[focal, 0, settings.width / 2], [0, focal, settings.height / 2], [0, 0, 1.0]])
    size = np.array([[settings.width, settings.height]], dtype=np.int64)
    return Cameras(transform[None], matrix[None], size)


def pose_of(world_to_camera: FloatArray, settings: CameraSettings) -> Pose:
    """Return the pose of a robot whose camera has this transform ``[4, 4]``; what is not level in it is left out."""
    rotation = world_to_camera[:3, :3]
    x, y, z = (float(value) for value in -rotation.T @ world_to_camera[:3, 3])
    return Pose(x, y, z - settings.above_floor, math.atan2(rotation[2, 1], rotation[2, 0]))


def cameras_at(poses: Sequence[Pose], settings: CameraSettings) -> Cameras:
    """Return the cameras of a robot at each of ``poses``, at least one."""
    return concatenate([camera_at(pose, settings) for pose in poses])
