"""The camera of a capture pattern."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras


@dataclass(frozen=True)
class Lens:
    """Camera of a capture pattern.

    Attributes:
        aspect: width over height.
        field_of_view: angle along the long side in degrees.
        exposure: factor on the exposure that suits the scene.
        exposure_jitter: standard deviation of each image's exposure, in stops.
        vignette: share of light lost in the corners.
    """

    aspect: float
    field_of_view: float
    exposure: float = 1.0
    exposure_jitter: float = 0.0
    vignette: float = 0.0

    def size(self, long_side: int) -> tuple[int, int]:
        """Return width and height in pixels."""
        short = max(1, round(long_side / max(self.aspect, 1 / self.aspect)))
        return (long_side, short) if self.aspect >= 1 else (short, long_side)

    def cameras(self, world_to_camera: npt.NDArray[np.float64], long_side: int) -> Cameras:
        """Return cameras at the poses ``[n, 4, 4]``, with square pixels and the principal point in the middle."""
        width, height = self.size(long_side)
        focal = long_side / 2 / np.tan(np.radians(self.field_of_view) / 2)
        intrinsics = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
        count = len(world_to_camera)
        return Cameras(
            world_to_camera, np.tile(intrinsics, (count, 1, 1)), np.tile(np.array([[width, height]]), (count, 1))
        )
