"""The dense cloud of views whose poses are known: a depth map for each, and their fusion."""

from __future__ import annotations

import numpy as np

from avs.scene.points import Points
from avs.scene.views import Views
from avs.sfm.cloud import empty_cloud
from avs.sfm.depth_maps import (
    DepthMap,
    FloatMap,
    Grey,
    Stereo,
    depth_map,
    grey_of,
    picture_of,
    refined,
    small_picture_of,
)
from avs.sfm.fusion import fused
from avs.sfm.reconstruction import Reconstruction
from avs.sfm.sfm_settings import FusionSettings, StereoSettings
from avs.sfm.source_views import inverse_depths, source_views
from avs.sfm.stereo_vectors import bordered


def dense_cloud(
    views: Views, points: Points, stereo: StereoSettings, fusion: FusionSettings, seed: int
) -> Reconstruction:
    """Return the fused depth maps of views; one that shows nothing in common with others has none.

    Args:
        views: at least two, of known poses.
        points: sparse points that tell their depths and which views go together.
        stereo: settings of the depth maps.
        fusion: settings of the cloud.
        seed: of PatchMatch.
    """
    maps = depth_maps(views, points, stereo, seed)
    lost = {
        name: "shows nothing in common with another view" for row, name in enumerate(views.names) if row not in maps
    }
    if not maps:
        return Reconstruction(empty_cloud(), (), lost)
    names = tuple(views.names[row] for row in maps)
    return Reconstruction(fused(views, maps, fusion), names, lost)


def depth_maps(views: Views, points: Points, settings: StereoSettings, seed: int) -> dict[int, DepthMap]:
    """Return the depth maps of views by row; a view without sources has none."""
    if not len(points):
        return {}
    pictures = [picture_of(grey_of(image)) for image in views.images]
    small = [small_picture_of(picture, settings.sweep_side) for picture in pictures]
    limits = inverse_depths(points, views.cameras)
    sources = {
        row: found for row, found in enumerate(source_views(points, views.cameras, settings.sources)) if len(found)
    }
    pairs = {
        row: Stereo(
            [pictures[row], *(pictures[other] for other in others)],
            [small[row], *(small[other] for other in others)],
            views.cameras[[row, *others.tolist()]],
            (limits[row, 0], limits[row, 1]),
        )
        for row, others in sources.items()
    }
    maps = {row: depth_map(stereo, settings, seed) for row, stereo in pairs.items()}
    for turn in range(settings.agreements):
        told = {row: _told(maps, row, pictures[row].grey) for row in range(len(views))}
        for row, stereo in pairs.items():  # each map in place of the one before: those of many views are large
            maps[row] = refined(
                stereo,
                maps[row].planes,
                _step(stereo.limits, settings) / 4,
                settings.agreement_iterations,
                settings.active,
                seed + 1 + turn,
                [told[other] for other in sources[row]],
            )
    return maps


def _told(maps: dict[int, DepthMap], row: int, grey: Grey) -> FloatMap:
    """Return the inverse depths of a view for the kernels, 0 if it has none."""
    return bordered(maps[row].planes[..., 0] if row in maps else np.zeros(grey.shape, dtype=np.float32))


def _step(limits: tuple[float, float], settings: StereoSettings) -> float:
    return (limits[1] - limits[0]) / (settings.planes - 1)
