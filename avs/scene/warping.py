"""Backward warping of an image into another camera, by the depth that this one sees."""

from __future__ import annotations

import numpy as np
import torch
import torch.nn.functional as functional
from torch import Tensor

from avs.scene.cameras import Cameras


def warped(image: Tensor, source: Cameras, depth: Tensor, target: Cameras) -> Tensor:
    """Return what ``target`` sees if every point looks as it does in ``image``.

    Bilinear; a point that projects outside the image takes the colour at its edge, one behind the source that of the
    point mirrored at its centre. Occlusions are not looked for.

    Args:
        image: ``[channels, height, width]`` of ``source``.
        source: one camera.
        depth: ``[h, w]``, distances along the target's optical axis.
        target: one camera.

    Returns:
        ``[channels, h, w]``.
    """
    # A pixel p = (x, y, 1) of depth d lies at d a p + b in homogeneous pixel coordinates of the source, scaled so that
    # -1 and 1 are the outer edges of its image: grid_sample's convention without align_corners.
    height, width = image.shape[1:]
    scaled = np.array([[2 / width, 0, -1], [0, 2 / height, -1], [0, 0, 1]]) @ source.intrinsics[0]
    relative = source.world_to_camera[0] @ np.linalg.inv(target.world_to_camera[0])
    a = (scaled @ relative[:3, :3] @ np.linalg.inv(target.intrinsics[0])).tolist()
    b = (scaled @ relative[:3, 3]).tolist()
    x = torch.arange(depth.shape[1], dtype=depth.dtype, device=depth.device) + 0.5
    y = torch.arange(depth.shape[0], dtype=depth.dtype, device=depth.device)[:, None] + 0.5
    u, v, w = ((row[0] * x + (row[1] * y + row[2])).mul_(depth).add_(shift) for row, shift in zip(a, b, strict=True))
    # where w is 0 a point projects nowhere; grid_sample documents what it does with NaN
    grid = torch.empty(*depth.shape, 2, dtype=depth.dtype, device=depth.device)
    torch.div(u, w, out=grid[..., 0])
    torch.div(v, w, out=grid[..., 1])
    sampled = functional.grid_sample(image[None], grid[None], padding_mode="border", align_corners=False)
    return sampled[0]
