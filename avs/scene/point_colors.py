"""Colours for points of structure from motion that came without: those of the photographs that observe them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from avs.scene.cameras import Cameras, IndexArray
from avs.scene.images import Pixels
from avs.scene.points import Points

GREY = 128
"""Where no photograph tells."""


def are_uncolored(points: Points) -> bool:
    """Whether all points have one colour: mappers that look for none write the same for all, mostly black."""
    return len(points) > 1 and bool((points.colors == points.colors[0]).all())


def painted(points: Points, cameras: Cameras, pool: IndexArray, read: Callable[[int], Pixels]) -> tuple[Points, str]:
    """Return the points with the mean colour of the pixels that observe them, and a line that tells so.

    Test images give none, which would show in a rendering of them. A point that no other image observes becomes grey.

    Args:
        points: their colours are not looked at.
        cameras: of all images.
        pool: indices of the images that are no test images.
        read: returns an image's pixels.
    """
    sums, counts = np.zeros((len(points), 3)), np.zeros(len(points), dtype=np.int64)
    for index in pool.tolist():
        rows = points.observations[points.observations[:, 1] == index, 0]
        if not len(rows):
            continue
        local = (
            points.positions[rows] @ cameras.world_to_camera[index, :3, :3].T + cameras.world_to_camera[index, :3, 3]
        )
        projected = local @ cameras.intrinsics[index].T
        pixels = np.floor(projected[:, :2] / projected[:, 2:])
        column, row = np.clip(pixels, 0, cameras.sizes[index] - 1).astype(np.int64).T
        sums[rows] += read(index)[row, column]
        counts[rows] += 1
    colors = np.full((len(points), 3), GREY, dtype=np.uint8)
    seen = counts > 0
    colors[seen] = np.rint(sums[seen] / counts[seen, None])
    told = f"the points came without colours: {seen.sum()} took those of the photographs that observe them"
    grey = f", {(~seen).sum()} that none observes are grey" if not seen.all() else ""
    return replace(points, colors=colors), told + grey
