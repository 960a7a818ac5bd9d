"""The rays of pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from avs.scene.cameras import Cameras, IndexArray


@dataclass(frozen=True)
class Rays:
    """n rays from camera centres through the centres of pixels, in scene units.

    Attributes:
        origins: ``[n, 3]`` float32.
        directions: ``[n, 3]`` float32, of length 1.
        along_axis: ``[n]`` float32, how far a ray comes along the optical axis for each unit of its length.
    """

    origins: Tensor
    directions: Tensor
    along_axis: Tensor

    def __len__(self) -> int:
        """Return the number of rays."""
        return len(self.origins)

    def part(self, begin: int, end: int) -> Rays:
        """Return the rays from ``begin`` up to ``end``."""
        return Rays(self.origins[begin:end], self.directions[begin:end], self.along_axis[begin:end])


def pixel_rays(cameras: Cameras, rows: IndexArray, x: IndexArray, y: IndexArray, device: torch.device) -> Rays:
    """Return the rays of pixels.

    Args:
        cameras: the cameras.
        rows: of each pixel's camera, ``[n]``.
        x: columns of the pixels, ``[n]``.
        y: rows of the pixels, ``[n]``.
        device: where the rays are to lie.
    """
    lens = cameras.intrinsics[rows]
    across = (x + 0.5 - lens[:, 0, 2]) / lens[:, 0, 0]
    down = (y + 0.5 - lens[:, 1, 2]) / lens[:, 1, 1]
    local = np.stack([across, down, np.ones(len(rows))], axis=1)
    lengths = np.linalg.norm(local, axis=1)
    directions = np.einsum("nji,nj->ni", cameras.world_to_camera[rows, :3, :3], local) / lengths[:, None]
    parts = (cameras.centers[rows], directions, 1 / lengths)
    return Rays(*(torch.from_numpy(part.astype(np.float32)).to(device) for part in parts))


def image_rays(camera: Cameras, device: torch.device) -> Rays:
    """Return the rays of all pixels of one camera, row by row."""
    width, height = (int(side) for side in camera.sizes[0])
    y, x = np.divmod(np.arange(width * height), width)
    return pixel_rays(camera, np.zeros(len(x), dtype=np.int64), x, y, device)
