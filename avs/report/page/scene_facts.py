"""What the page tells of a scene: its cameras, points and photographs, and how its episodes went."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from avs.nvs.record import Episode
from avs.report.collect import Episodes, image_mean
from avs.report.figures.overview import outline_depth, outlines, overview_of
from avs.report.methods import presented
from avs.report.page.method_facts import method_facts
from avs.report.page.page_settings import PageSettings
from avs.report.page.script_files import encoded, rounded
from avs.scene.even_places import evenly_spread
from avs.scene.scene import Scene
from avs.system.reasons import Reason

CURVE = ("psnr", "ssim", "lpips")
"""The metrics of a curve, in order."""


def scene_facts(
    scene: Scene, episodes: Episodes, methods: Sequence[str], absent: Mapping[str, Reason], settings: PageSettings
) -> dict[str, Any]:
    """Return what does not depend on a single episode, and of each episode what lists and charts show.

    Args:
        scene: the scene.
        episodes: its episodes.
        methods: identifiers of all methods of the run, in order.
        absent: why one has no episode, by identifier.
        settings: of the page.
    """
    return {
        "dataset": scene.dataset,
        "scene": scene.name,
        "source": scene.source,
        "licence": scene.licence,
        "notes": list(scene.notes),
        "hash": scene.content_hash,
        "names": list(scene.names),
        "test": scene.test.tolist(),
        "cameras": _cameras(scene),
        "points": _points(scene, settings.points),
        "methods": method_facts([presented(method, episodes) for method in methods], absent),
        "episodes": {
            f"{method}-{seed}": _summary(episode)
            for method, cells in episodes.cells.items()
            for (_, seed), episode in cells.items()
        },
    }


def _cameras(scene: Scene) -> dict[str, Any]:
    """Return centres and corners of pictures at depth 1, and from where all of them are seen well."""
    overview = overview_of(scene.cameras[scene.pool])
    return {
        "outlines": rounded(outlines(scene.cameras, 1.0).ravel().tolist()),
        "depth": outline_depth(scene.cameras[scene.pool], overview),
        "right": overview.right.tolist(),
        "up": overview.up.tolist(),
        "forward": overview.forward.tolist(),
        "down": rounded(scene.cameras.world_to_camera[:, 1, :3].ravel().tolist()),
        "height": rounded((2 * np.arctan(scene.cameras.sizes[:, 1] / 2 / scene.cameras.intrinsics[:, 1, 1])).tolist()),
    }


def _points(scene: Scene, most: int) -> dict[str, Any]:
    rows = evenly_spread(len(scene.points), most)
    return {
        "xyz": rounded(scene.points.positions[rows].ravel().tolist()),
        "rgb": encoded(np.ascontiguousarray(scene.points.colors[rows]).tobytes()),
    }


def _summary(episode: Episode) -> dict[str, Any]:
    curve = [
        [point.views, point.iteration, point.primitives, *(image_mean(point, metric) for metric in CURVE)]
        for point in episode.curve
    ]
    return {"method": episode.method, "seed": episode.seed, "budget": episode.budget, "curve": curve}
