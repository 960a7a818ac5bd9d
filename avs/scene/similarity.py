"""Similarity transforms without rotation: from a scene's coordinates to those of the capture that it was made from."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from avs.scene.cameras import Cameras, FloatArray
from avs.system.models import StrictModel


class Similarity(StrictModel):
    """The map ``x -> scale x + translation`` of world coordinates, and its inverse. Everything runs in float64."""

    scale: float = Field(gt=0, description="units of the target in one unit of the source")
    translation: tuple[float, float, float] = Field(description="the source's origin in the target's coordinates")

    def points(self, positions: FloatArray) -> FloatArray:
        """Return positions ``[..., 3]`` of the source in the target's coordinates."""
        moved: FloatArray = positions * self.scale + np.array(self.translation)
        return moved

    def points_back(self, positions: FloatArray) -> FloatArray:
        """Return positions ``[..., 3]`` of the target in the source's coordinates."""
        moved: FloatArray = (positions - np.array(self.translation)) / self.scale
        return moved

    def cameras(self, cameras: Cameras) -> Cameras:
        """Return cameras of the source in the target's coordinates; they see what they saw."""
        rotations, translations = cameras.world_to_camera[:, :3, :3], cameras.world_to_camera[:, :3, 3]
        return _moved(cameras, translations * self.scale - rotations @ np.array(self.translation))

    def cameras_back(self, cameras: Cameras) -> Cameras:
        """Return cameras of the target in the source's coordinates; they see what they saw."""
        rotations, translations = cameras.world_to_camera[:, :3, :3], cameras.world_to_camera[:, :3, 3]
        return _moved(cameras, (translations + rotations @ np.array(self.translation)) / self.scale)


IDENTITY = Similarity(scale=1.0, translation=(0.0, 0.0, 0.0))
"""Changes nothing."""


def _moved(cameras: Cameras, translations: FloatArray) -> Cameras:
    """Return ``cameras`` with the ``[n, 3]`` translations in the place of their own."""
    transforms = cameras.world_to_camera.copy()
    transforms[:, :3, 3] = translations
    return Cameras(transforms, cameras.intrinsics, cameras.sizes)
