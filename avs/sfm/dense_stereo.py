"""The dense cloud of views whose poses are known: a depth map for each, and their fusion."""

from __future__ import annotations

import numpy as np

from avs.scene.points import Points
from avs.scene.views import Views
from avs.sfm.cloud import empty_cloud
from avs.sfm.depth_maps import DepthMap, FloatMap, Grey, Stereo, depth_map, grey_of, refined
from avs.sfm.fusion import fused
from avs.sfm.reconstruction import Reconstruction
from avs.sfm.sfm_settings import FusionSettings, StereoSettings
from avs.sfm.source_views import inverse_depths, source_views


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
    return Reconstruction(fused(views, maps, fusion), tuple(views.names[row] for row in maps), lost)


def depth_maps(views: Views, points: Points, settings: StereoSettings, seed: int) -> dict[int, DepthMap]:
    """Return the depth maps of views by row; a view without sources has none."""
    if not len(points):
        return {}
    greys = [grey_of(image) for image in views.images]
    limits = inverse_depths(points, views.cameras)
    sources = {
        row: found for row, found in enumerate(source_views(points, views.cameras, settings.sources)) if len(found)
    }
    pairs = {
        row: Stereo(
            [greys[row], *(greys[other] for other in others)],
            views.cameras[[row, *others.tolist()]],
            (limits[row, 0], limits[row, 1]),
        )
        for row, others in sources.items()
    }
    maps = {row: depth_map(stereo, settings, seed) for row, stereo in pairs.items()}
    for turn in range(settings.agreements):
        told = {row: _told(maps, row, greys[row]) for row in range(len(views))}
        maps = {
            row: refined(
                stereo,
                maps[row].planes,
                _step(stereo.limits, settings) / 4,
                settings.agreement_iterations,
                seed + 1 + turn,
                [told[other] for other in sources[row]],
            )
            for row, stereo in pairs.items()
        }
    return maps


def _told(maps: dict[int, DepthMap], row: int, grey: Grey) -> FloatMap:
    """Return the inverse depths of a view, 0 if it has none."""
    if row in maps:
        return np.ascontiguousarray(maps[row].planes[..., 0])
    return np.zeros(grey.shape, dtype=np.float32)


def _step(limits: tuple[float, float], settings: StereoSettings) -> float:
    return (limits[1] - limits[0]) / (settings.planes - 1)
