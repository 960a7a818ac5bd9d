"""Backward warping of an image into other cameras, by the depth that these see."""

from __future__ import annotations

import numpy as np
import torch
import torch.nn.functional as functional
from torch import Tensor

from avs.cameras import Cameras


def warped(image: Tensor, source: Cameras, depth: Tensor, targets: Cameras) -> Tensor:
    """Return what ``targets`` see if every point looks as it does in ``image``.

    Bilinear; a point that projects outside the image takes the colour at its edge, one behind the source that of the
    point mirrored at its centre. Occlusions are not looked for.

    Args:
        image: ``[channels, height, width]`` of ``source``.
        source: one camera.
        depth: ``[n, h, w]``, distances along the targets' optical axes.
        targets: n cameras of one image size.

    Returns:
        ``[n, channels, h, w]``.
    """
    # a pixel p = (x, y, 1) of depth d lies at d a p + b in the homogeneous pixel coordinates of the source
    relative = source.world_to_camera @ np.linalg.inv(targets.world_to_camera)
    linear = source.intrinsics @ relative[:, :3, :3] @ np.linalg.inv(targets.intrinsics)
    a, b = (torch.from_numpy(x).to(depth) for x in (linear, source.intrinsics[0] @ relative[:, :3, 3, None]))
    n, height, width = depth.shape
    x = torch.arange(width, dtype=depth.dtype, device=depth.device) + 0.5
    y = torch.arange(height, dtype=depth.dtype, device=depth.device)[:, None] + 0.5

    def coordinate(row: int) -> Tensor:
        a_x, a_y, a_1, b_1 = (v[:, None, None] for v in (a[:, row, 0], a[:, row, 1], a[:, row, 2], b[:, row, 0]))
        return torch.addcmul(b_1, depth, a_x * x + (a_y * y + a_1))

    # in the plane of the source's centre a point projects nowhere: far outside will do
    inverse = coordinate(2).reciprocal_().nan_to_num_()
    grid = torch.empty(n, height, width, 2, dtype=depth.dtype, device=depth.device)
    for axis, size in ((0, image.shape[2]), (1, image.shape[1])):
        torch.mul(coordinate(axis), inverse, out=grid[..., axis]).mul_(2 / size).sub_(1)
    # with align_corners=False, -1 and 1 are the outer edges of the image, so that pixel centres are at half integers
    return functional.grid_sample(
        image.expand(n, -1, -1, -1), grid, mode="bilinear", padding_mode="border", align_corners=False
    )
