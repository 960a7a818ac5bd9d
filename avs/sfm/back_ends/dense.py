"""Dense stereo on the CPU: sparse points by COLMAP, depth maps by kernels of this suite, and COLMAP's fusion."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, cast

from pydantic import Field

from avs.scene.views import Views
from avs.sfm.reconstruction import FEWEST, BackEnd, BackEndSettings, Poses, Reconstruction
from avs.sfm.sfm_settings import FeatureSettings, FusionSettings, GuidedSettings, StereoSettings


class DenseSettings(BackEndSettings):
    """Settings of dense stereo."""

    back_end: Literal["dense"] = Field(default="dense", description="Dense stereo")
    poses: Poses = Field(default="known", description="whether the cameras' poses are given, or found")
    points: GuidedSettings = Field(default_factory=GuidedSettings, description="of sparse points between known poses")
    features: FeatureSettings = Field(default_factory=FeatureSettings, description="of the mapping that finds poses")
    stereo: StereoSettings = Field(default_factory=StereoSettings, description="of the depth maps")
    fusion: FusionSettings = Field(default_factory=FusionSettings, description="of the cloud")


def reconstruct(views: Views, settings: BackEndSettings, device: str) -> Reconstruction:
    """Return the fused cloud of the views' depth maps; a view that shows nothing in common with others has none.

    With free poses, incremental mapping comes first, and stereo uses the cameras that it finds.

    Args:
        views: at least two.
        settings: ``DenseSettings``.
        device: not used, all of it runs on the CPU.
    """
    from avs.sfm.dense_stereo import dense_cloud
    from avs.sfm.guided_points import guided_points
    from avs.sfm.sparse_models import mapped

    told = cast(DenseSettings, settings)
    if told.poses == "known":
        return dense_cloud(views, guided_points(views, told.points), told.stereo, told.fusion, told.seed)
    sparse = mapped(views, told.features, told.seed)
    found = sparse.reconstruction
    if found.cameras is None or len(found.registered) < FEWEST:
        return found
    here = replace(views[[views.names.index(name) for name in found.registered]], cameras=found.cameras)
    dense = dense_cloud(here, sparse.points, told.stereo, told.fusion, told.seed)
    rows = [found.registered.index(name) for name in dense.registered]
    return replace(dense, left_out={**found.left_out, **dense.left_out}, cameras=found.cameras[rows], notes=found.notes)


BACK_END = BackEnd(
    label="Dense stereo",
    settings=DenseSettings,
    reconstruct="avs.sfm.back_ends.dense:reconstruct",
    packages={"pycolmap": "pip install pycolmap==4.2.1"},
    versions={"pycolmap": "4.2."},
    source="Schoenberger et al., Pixelwise View Selection for Unstructured Multi-View Stereo, ECCV 2016 (fusion)",
    licence="BSD-3-Clause (COLMAP)",
)
