"""Depth Anything 3: depth maps of all views in one pass, with their poses if known. Its own package, weights."""

from __future__ import annotations

from typing import Any, Literal, cast

import numpy as np
import numpy.typing as npt
from pydantic import Field

from avs.scene.views import Views
from avs.sfm.point_maps import NetworkSettings, PointMaps, as_array, inverses, reconstruction_of
from avs.sfm.reconstruction import BackEnd, BackEndSettings, Poses, Reconstruction
from avs.system.compatibility import prepare_torchvision


class DepthAnythingSettings(NetworkSettings):
    """Settings of Depth Anything 3."""

    back_end: Literal["da3"] = Field(default="da3", description="Depth Anything 3")
    poses: Poses = Field(default="known", description="whether the cameras' poses are given, or found")
    side: int = Field(default=504, description="long side in pixels of the pictures that the network gets")
    least_confidence: float = Field(default=1.0, description="of a point, in the network's own unit")


def reconstruct(views: Views, settings: BackEndSettings, device: str) -> Reconstruction:
    """Return the points of Depth Anything's depth maps.

    Args:
        views: at least two.
        settings: ``DepthAnythingSettings``.
        device: ``cpu`` or ``cuda``.
    """
    told = cast(DepthAnythingSettings, settings)
    prepare_torchvision()
    import torch
    from depth_anything_3.api import DepthAnything3

    torch.manual_seed(told.seed)
    model = DepthAnything3.from_pretrained(str(told.weights)).to(device).eval()
    known = told.poses == "known"
    said = model.inference(
        list(views.images),
        extrinsics=views.cameras.world_to_camera.astype(np.float32) if known else None,
        intrinsics=views.cameras.intrinsics.astype(np.float32) if known else None,
        align_to_input_ext_scale=True,
        process_res=told.side,
    )
    poses = inverses(as_array(said.extrinsics))
    depths, matrices = as_array(said.depth), as_array(said.intrinsics)
    maps = PointMaps(
        [_points(*one) for one in zip(depths, matrices, poses, strict=True)],
        list(as_array(said.processed_images)),
        list(as_array(said.conf)),
        poses,
    )
    return reconstruction_of(maps, views, told)


def _points(depth: npt.NDArray[Any], matrix: npt.NDArray[Any], pose: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the world positions ``[h, w, 3]`` of a depth map, whose pixels count from the middle of the first one."""
    rows, columns = np.indices(depth.shape)
    pixels = np.stack([columns, rows, np.ones_like(rows)], axis=-1)
    local = pixels @ np.linalg.inv(matrix).T * depth[..., None]
    points: npt.NDArray[Any] = local @ pose[:3, :3].T + pose[:3, 3]
    return points


BACK_END = BackEnd(
    label="Depth Anything 3",
    settings=DepthAnythingSettings,
    reconstruct="avs.sfm.back_ends.da3:reconstruct",
    packages={"depth_anything_3": "pip install depth-anything-3==0.1.1, in an environment of its own (numpy below 2)"},
    versions={"depth-anything-3": "0.1."},
    source="Lin et al., Depth Anything 3: Recovering the Visual Space from Any Views, 2025",
    licence="Apache-2.0 (code; weights SMALL, BASE), CC BY-NC 4.0 (LARGE, GIANT)",
)
