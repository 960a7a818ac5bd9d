"""COLMAP's sparse points on the CPU: triangulated between the known cameras, or mapped with cameras that it finds."""

from __future__ import annotations

from typing import Literal, cast

from pydantic import Field

from avs.scene.views import Views
from avs.sfm.reconstruction import BackEnd, BackEndSettings, Poses, Reconstruction
from avs.sfm.sfm_settings import FeatureSettings


class ColmapSettings(BackEndSettings):
    """Settings of COLMAP."""

    back_end: Literal["colmap"] = Field(default="colmap", description="COLMAP")
    poses: Poses = Field(default="known", description="whether the cameras' poses are given, or found")
    features: FeatureSettings = Field(default_factory=FeatureSettings, description="of SIFT and of matching")


def reconstruct(views: Views, settings: BackEndSettings, device: str) -> Reconstruction:
    """Return the points that at least two views see, with the number of views as their confidence.

    Args:
        views: at least two.
        settings: ``ColmapSettings``.
        device: not used, all of it runs on the CPU.
    """
    from avs.sfm.sparse_models import mapped, triangulated

    told = cast(ColmapSettings, settings)
    find = triangulated if told.poses == "known" else mapped
    return find(views, told.features, told.seed).reconstruction


BACK_END = BackEnd(
    label="COLMAP",
    settings=ColmapSettings,
    reconstruct="avs.sfm.back_ends.colmap:reconstruct",
    packages={"pycolmap": "pip install pycolmap==4.2.1"},
    versions={"pycolmap": "4.2."},
    source="Schoenberger and Frahm, Structure-from-Motion Revisited, CVPR 2016",
    licence="BSD-3-Clause",
)
