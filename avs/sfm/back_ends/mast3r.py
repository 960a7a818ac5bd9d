"""MASt3R with sparse global alignment, as the paper uses it: poses are always free. Its own package and weights."""

from __future__ import annotations

from typing import Literal, cast

import numpy as np
from pydantic import Field

from avs.scene.views import Views
from avs.sfm.point_maps import (
    NetworkSettings,
    PictureFiles,
    PointMaps,
    as_array,
    as_bytes,
    reconstruction_of,
)
from avs.sfm.reconstruction import BackEnd, BackEndSettings, Reconstruction
from avs.system.compatibility import prepare_torchvision
from avs.system.files import temporary_folder


class Mast3rSettings(NetworkSettings):
    """Settings of MASt3R; those of the alignment are the demo's, but for the matching threshold the function's."""

    back_end: Literal["mast3r"] = Field(default="mast3r", description="MASt3R")
    poses: Literal["free"] = Field(default="free", description="it finds the cameras' poses by itself")
    graph: str = Field("complete", description="which pairs are compared; complete, or swin-5-noncyclic for many views")
    first_rate: float = Field(0.07, gt=0, description="learning rate of the coarse alignment")
    first_steps: int = Field(300, ge=1, description="steps of the coarse alignment")
    second_rate: float = Field(0.01, gt=0, description="learning rate of the refinement")
    second_steps: int = Field(300, ge=0, description="steps of the refinement")
    matching_confidence: float = Field(5.0, ge=0, description="of a pair's best match (function: 5, demo: 0)")


def reconstruct(views: Views, settings: BackEndSettings, device: str) -> Reconstruction:
    """Return the points that MASt3R is sure enough of, in a frame of their own.

    Args:
        views: at least two; n (n - 1) pairs are compared by the complete graph.
        settings: ``Mast3rSettings``.
        device: ``cpu`` or ``cuda``.
    """
    told = cast(Mast3rSettings, settings)
    prepare_torchvision()
    import mast3r.utils.path_to_dust3r  # noqa: F401 - makes dust3r importable
    import torch
    from dust3r.utils.image import load_images
    from mast3r.cloud_opt.sparse_ga import sparse_global_alignment
    from mast3r.image_pairs import make_pairs
    from mast3r.model import AsymmetricMASt3R

    torch.manual_seed(told.seed)
    model = AsymmetricMASt3R.from_pretrained(str(told.weights)).to(device).eval()
    with PictureFiles(views) as paths, temporary_folder("avs-mast3r-") as cache:
        pairs = make_pairs(
            load_images(paths, size=told.side, verbose=False), scene_graph=told.graph, prefilter=None, symmetrize=True
        )
        scene = sparse_global_alignment(
            paths,
            pairs,
            str(cache),
            model,
            lr1=told.first_rate,
            niter1=told.first_steps,
            lr2=told.second_rate,
            niter2=told.second_steps,
            device=device,
            opt_depth=True,
            shared_intrinsics=False,
            matching_conf_thr=told.matching_confidence,
        )
        positions, _, confidence = scene.get_dense_pts3d(clean_depth=True)
    shapes = [as_array(one).shape for one in confidence]
    maps = PointMaps(
        [as_array(one).reshape(*shape, 3) for one, shape in zip(positions, shapes, strict=True)],
        [as_bytes(one) for one in scene.imgs],
        [as_array(one) for one in confidence],
        as_array(scene.get_im_poses()).astype(np.float64),
    )
    return reconstruction_of(maps, views, told)


BACK_END = BackEnd(
    label="MASt3R",
    settings=Mast3rSettings,
    reconstruct="avs.sfm.back_ends.mast3r:reconstruct",
    packages={"mast3r": "clone github.com/naver/mast3r with its submodules and put it on PYTHONPATH"},
    source="Leroy et al., Grounding Image Matching in 3D with MASt3R, ECCV 2024",
    licence="CC BY-NC-SA 4.0 (code and weights)",
)
