"""MapAnything: all views in one pass of a transformer, with their poses if they are known. Its own package, weights."""

from __future__ import annotations

from typing import Any, Literal, cast

import numpy as np
from pydantic import Field

from avs.scene.views import Views
from avs.sfm.point_maps import NetworkSettings, PointMaps, as_array, as_bytes, reconstruction_of
from avs.sfm.reconstruction import BackEnd, BackEndSettings, Poses, Reconstruction
from avs.system.compatibility import prepare_torchvision


class MapAnythingSettings(NetworkSettings):
    """Settings of MapAnything; it resizes pictures itself, and its mask says which points it trusts."""

    back_end: Literal["mapanything"] = Field(default="mapanything", description="MapAnything")
    poses: Poses = Field(default="known", description="whether the cameras' poses are given, or found")
    side: Literal[518] = Field(default=518, description="long side in pixels of the pictures that the network gets")
    least_confidence: float = Field(default=0.0, description="of a point, in the network's own unit")


def reconstruct(views: Views, settings: BackEndSettings, device: str) -> Reconstruction:
    """Return the points of MapAnything's mask.

    Args:
        views: at least two.
        settings: ``MapAnythingSettings``.
        device: ``cpu`` or ``cuda``.
    """
    told = cast(MapAnythingSettings, settings)
    prepare_torchvision()
    import torch
    from mapanything.models import MapAnything
    from mapanything.utils.image import preprocess_inputs

    torch.manual_seed(told.seed)
    model = MapAnything.from_pretrained(str(told.weights)).to(device).eval()
    with torch.no_grad():
        said = model.infer(
            preprocess_inputs(_inputs(views, told.poses == "known")),
            memory_efficient_inference=True,
            use_amp=device == "cuda",
            amp_dtype="bf16",
            apply_mask=True,
            mask_edges=True,
            apply_confidence_mask=False,
        )
    maps = PointMaps(
        [as_array(one["pts3d"])[0] for one in said],
        [as_bytes(one["img_no_norm"])[0] for one in said],
        [np.where(as_array(one["mask"])[0, ..., 0], as_array(one["conf"])[0], np.nan) for one in said],
        np.concatenate([as_array(one["camera_poses"]) for one in said]).astype(np.float64),
    )
    return reconstruction_of(maps, views, told)


def _inputs(views: Views, known: bool) -> list[dict[str, Any]]:
    """Return what MapAnything takes: pictures of 0..255, intrinsics, and camera-to-world poses without a unit."""
    import torch

    inputs = []
    for row, image in enumerate(views.images):
        one: dict[str, Any] = {
            "img": torch.from_numpy(image),
            "intrinsics": torch.from_numpy(views.cameras.intrinsics[row]).float(),
        }
        if known:
            pose = np.linalg.inv(views.cameras.world_to_camera[row])
            one |= {"camera_poses": torch.from_numpy(pose).float(), "is_metric_scale": torch.tensor([False])}
        inputs.append(one)
    return inputs


BACK_END = BackEnd(
    label="MapAnything",
    settings=MapAnythingSettings,
    reconstruct="avs.sfm.back_ends.mapanything:reconstruct",
    packages={"mapanything": "clone github.com/facebookresearch/map-anything and run pip install -e in it"},
    source="Keetha et al., MapAnything: Universal Feed-Forward Metric 3D Reconstruction, 2025",
    licence="Apache-2.0 (code), Apache-2.0 or CC BY-NC 4.0 (weights)",
)
