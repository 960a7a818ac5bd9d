"""The map: isotropic Gaussians of one colour each, their rendering, and adding and removing some."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import Parameter

from avs.rasterizer.rasterization import rasterization
from avs.scene.cameras import Cameras
from avs.slam.building.simulator import Frame

MapTensors = dict[str, Parameter]
"""The trainable tensors of n Gaussians:

- ``means`` ``[n, 3]``: positions, metres.
- ``rgb`` ``[n, 3]``: colours, sRGB.
- ``opacities`` ``[n]``: logits.
- ``scales`` ``[n, 1]``: logarithm of the standard deviation, metres.
"""

NAMES = ("means", "rgb", "opacities", "scales")


@dataclass(frozen=True)
class Seen:
    """A rendering of the map.

    Attributes:
        rgb: ``[height, width, 3]`` colours, black behind.
        depth: ``[height, width]`` metres, blended and not divided by ``alpha``, as SplaTAM has it.
        alpha: ``[height, width]`` accumulated opacity: the silhouette.
    """

    rgb: Tensor
    depth: Tensor
    alpha: Tensor


def empty_map() -> MapTensors:
    """Return a map without Gaussians."""
    shapes = {"means": (0, 3), "rgb": (0, 3), "opacities": (0,), "scales": (0, 1)}
    return {name: Parameter(torch.empty(shape)) for name, shape in shapes.items()}


def map_rendering(tensors: MapTensors, viewmat: Tensor, intrinsics: Tensor, width: int, height: int) -> Seen:
    """Return the rendering, differentiable in the map and in ``viewmat`` ``[4, 4]``, by one pass of the rasteriser."""
    count = len(tensors["means"])
    image, alpha, _ = rasterization(
        means=tensors["means"],
        quats=torch.tensor([1.0, 0.0, 0.0, 0.0]).expand(count, 4),
        scales=tensors["scales"].exp().expand(count, 3),
        opacities=tensors["opacities"].sigmoid(),
        colors=tensors["rgb"],
        viewmats=viewmat[None],
        Ks=intrinsics[None],
        width=width,
        height=height,
        render_mode="RGB+D",
    )
    return Seen(image[0, ..., :3], image[0, ..., 3], alpha[0, ..., 0])


def map_seen(tensors: MapTensors, camera: Cameras) -> Seen:
    """Return the rendering from one camera, without gradients."""
    width, height = (int(side) for side in camera.sizes[0])
    with torch.no_grad():
        return map_rendering(tensors, *camera_tensors(camera), width, height)


def camera_tensors(camera: Cameras) -> tuple[Tensor, Tensor]:
    """Return world-to-camera matrix and intrinsics of one camera as float32."""
    return (
        torch.tensor(camera.world_to_camera[0], dtype=torch.float32),
        torch.tensor(camera.intrinsics[0], dtype=torch.float32),
    )


def points_of(frame: Frame, camera: Cameras, where: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
    """Return the points ``[k, 3]`` in the world that the pixels ``where`` ``[height, width]`` show, row by row."""
    rows, columns = np.nonzero(where)
    depth = frame.depth[rows, columns].astype(np.float64)
    matrix, pose = camera.intrinsics[0], camera.world_to_camera[0]
    plane = (np.stack([columns, rows], axis=1) + 0.5 - matrix[:2, 2]) / matrix[[0, 1], [0, 1]]
    local = np.concatenate([plane, np.ones((len(plane), 1))], axis=1) * depth[:, None]
    return np.asarray((local - pose[:3, 3]) @ pose[:3, :3])


def gaussians_of(
    frame: Frame, camera: Cameras, where: npt.NDArray[np.bool_], opacity: float, size: float
) -> dict[str, Tensor]:
    """Return a Gaussian for each pixel ``where``, as SplaTAM starts them.

    Each lies at the pixel's depth, has its colour, and a standard deviation of ``size`` times what a pixel spans there.
    """
    rows, columns = np.nonzero(where)
    focal = (camera.intrinsics[0, 0, 0] + camera.intrinsics[0, 1, 1]) / 2
    values = {
        "means": points_of(frame, camera, where),
        "rgb": frame.rgb[rows, columns] / 255.0,
        "opacities": np.full(len(rows), math.log(opacity / (1 - opacity))),
        "scales": np.log(frame.depth[rows, columns, None].astype(np.float64) * size / focal),
    }
    return {name: torch.tensor(values[name], dtype=torch.float32) for name in NAMES}


def extended(tensors: MapTensors, more: dict[str, Tensor]) -> MapTensors:
    """Return the map with more Gaussians behind its own."""
    return {name: Parameter(torch.cat([tensors[name].detach(), more[name]])) for name in NAMES}
