"""VGGT: all views in one pass of a transformer; poses are always free. Its own package and weights."""

from __future__ import annotations

from typing import Literal, cast

from pydantic import Field

from avs.scene.views import Views
from avs.sfm.point_maps import (
    NetworkSettings,
    PictureFiles,
    PointMaps,
    as_array,
    as_bytes,
    inverses,
    reconstruction_of,
)
from avs.sfm.reconstruction import BackEnd, BackEndSettings, Reconstruction
from avs.system.compatibility import prepare_torchvision


class VggtSettings(NetworkSettings):
    """Settings of VGGT; it makes its pictures 518 pixels wide itself."""

    back_end: Literal["vggt"] = Field(default="vggt", description="VGGT")
    poses: Literal["free"] = Field(default="free", description="it finds the cameras' poses by itself")
    side: Literal[518] = Field(default=518, description="long side in pixels of the pictures that the network gets")
    least_confidence: float = Field(default=2.0, description="of a point, in the network's own unit")


def reconstruct(views: Views, settings: BackEndSettings, device: str) -> Reconstruction:
    """Return the points of VGGT's depth maps, which its authors find more precise than its point maps.

    Args:
        views: at least two; memory grows with their number (20 views: 5.6 GB).
        settings: ``VggtSettings``.
        device: ``cpu`` or ``cuda``.
    """
    told = cast(VggtSettings, settings)
    prepare_torchvision()
    import torch
    from vggt.models.vggt import VGGT
    from vggt.utils.geometry import unproject_depth_map_to_point_map
    from vggt.utils.load_fn import load_and_preprocess_images
    from vggt.utils.pose_enc import pose_encoding_to_extri_intri

    torch.manual_seed(told.seed)
    model = VGGT.from_pretrained(str(told.weights)).to(device).eval()
    with PictureFiles(views) as paths:
        images = load_and_preprocess_images(paths).to(device)
    with torch.no_grad():
        said = model(images)
    extrinsics, intrinsics = pose_encoding_to_extri_intri(said["pose_enc"], images.shape[-2:])
    points = unproject_depth_map_to_point_map(
        as_array(said["depth"])[0], as_array(extrinsics)[0], as_array(intrinsics)[0]
    )
    maps = PointMaps(
        list(as_array(points)),
        list(as_bytes(images.permute(0, 2, 3, 1))),
        list(as_array(said["depth_conf"])[0]),
        inverses(as_array(extrinsics)[0]),
    )
    return reconstruction_of(maps, views, told)


BACK_END = BackEnd(
    label="VGGT",
    settings=VggtSettings,
    reconstruct="avs.sfm.back_ends.vggt:reconstruct",
    packages={"vggt": "clone github.com/facebookresearch/vggt and run pip install -e in it"},
    source="Wang et al., VGGT: Visual Geometry Grounded Transformer, CVPR 2025",
    licence="VGGT License (Meta)",
)
