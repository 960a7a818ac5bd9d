"""The dense cloud of a sparse model: a depth map for each view, and their fusion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avs.scene.cameras import Cameras
from avs.scene.views import Views
from avs.sfm.cloud import empty_cloud
from avs.sfm.depth_maps import DepthMap, depth_map, grey_of
from avs.sfm.fusion import fused
from avs.sfm.reconstruction import Reconstruction
from avs.sfm.sfm_settings import FusionSettings, StereoSettings
from avs.sfm.source_views import inverse_depths, source_views
from avs.sfm.sparse_models import SparseModel


def dense_cloud(
    views: Views, sparse: SparseModel, stereo: StereoSettings, fusion: FusionSettings, seed: int
) -> Reconstruction:
    """Return the fused depth maps of the views that a sparse model holds.

    Args:
        views: at least two.
        sparse: their sparse model; its cameras, if it found any, take the place of the views' own.
        stereo: settings of the depth maps.
        fusion: settings of the cloud.
        seed: of PatchMatch.
    """
    found = sparse.reconstruction
    here = views[[views.names.index(name) for name in found.registered]]
    if found.cameras is not None:
        here = replace(here, cameras=found.cameras)
    if not len(sparse.points):
        return replace(found, cloud=empty_cloud())
    maps = depth_maps(here, sparse, stereo, seed)
    return replace(found, cloud=fused(here, maps, fusion))


def depth_maps(views: Views, sparse: SparseModel, settings: StereoSettings, seed: int) -> dict[int, DepthMap]:
    """Return the depth maps of the views of a sparse model by row; a view without sources has none."""
    greys = [grey_of(image) for image in views.images]
    sources = source_views(sparse.points, views.cameras, settings.sources)
    limits = inverse_depths(sparse.points, views.cameras)
    return {
        row: depth_map(
            [greys[row], *(greys[other] for other in others)],
            _of(views.cameras, row, others.tolist()),
            (limits[row, 0], limits[row, 1]),
            settings,
            seed,
        )
        for row, others in enumerate(sources)
        if len(others)
    }


def _of(cameras: Cameras, row: int, others: list[int]) -> Cameras:
    return cameras[np.array([row, *others], dtype=np.int64)]
