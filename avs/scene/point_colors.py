"""Colours for points of structure from motion that came without: those of the photographs that observe them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, FloatArray, IndexArray
from avs.scene.images import Pixels
from avs.scene.points import Points

GREY = 128
"""Where no photograph tells."""

DARK = 32
"""Up to this value of its brightest channel a photograph shows a point that may have been written as black."""


def colored(
    points: Points, cameras: Cameras, pool: IndexArray, read: Callable[[int], Pixels]
) -> tuple[Points, str | None]:
    """Return the points with a colour for each, and a line about those that came without one.

    Mappers that look for none write one colour for all, mostly black. A black point among others may be black indeed,
    and counts as one without a colour if the photographs are brighter than ``DARK`` there. Such points get the mean
    colour of the pixels that observe them. Test images give none, which would show in a rendering of them. If no point
    has a colour, those that no other image observes become grey; otherwise they keep their black.

    Args:
        points: of a scene.
        cameras: of all images.
        pool: indices of the images that are no test images.
        read: returns an image's pixels.
    """
    none = len(points) > 1 and bool((points.colors == points.colors[0]).all())
    rows = np.arange(len(points)) if none else np.flatnonzero((points.colors == 0).all(axis=1))
    if not len(rows):
        return points, None
    means, seen = _photographed(points, rows, cameras, pool, read)
    changed = seen if none else seen & (means > DARK).any(axis=1)
    colors = points.colors.copy()
    if none:
        colors[:] = GREY
    colors[changed] = means[changed]
    lacking = len(points) if none else int(changed.sum())
    grey = f", {(~seen).sum()} that none observes are grey" if none and not seen.all() else ""
    note = (
        f"{lacking} of {len(points)} points came without colours: {changed.sum()} took those of the photographs{grey}"
    )
    return replace(points, colors=colors), note if lacking else None


def _photographed(
    points: Points, rows: IndexArray, cameras: Cameras, pool: IndexArray, read: Callable[[int], Pixels]
) -> tuple[Pixels, npt.NDArray[np.bool_]]:
    """Return the mean colours ``[p, 3]`` in the images of the pool, and which of ``rows`` have one, ``[p]``."""
    sums, counts = np.zeros((len(points), 3)), np.zeros(len(points), dtype=np.int64)
    wanted = points.observations[np.isin(points.observations[:, 0], rows)]
    for index in pool.tolist():
        seen = wanted[wanted[:, 1] == index, 0]
        if len(seen):
            sums[seen] += pixels_of(points.positions[seen], cameras[index], read(index))
            counts[seen] += 1
    return np.rint(sums / np.maximum(counts, 1)[:, None]).astype(np.uint8), counts > 0


def pixels_of(positions: FloatArray, camera: Cameras, image: Pixels) -> Pixels:
    """Return the colours ``[n, 3]`` of the pixels of ``image`` into which its camera projects the positions."""
    local = positions @ camera.world_to_camera[0, :3, :3].T + camera.world_to_camera[0, :3, 3]
    projected = local @ camera.intrinsics[0].T
    pixels = np.floor(projected[:, :2] / projected[:, 2:])
    column, row = np.clip(pixels, 0, camera.sizes[0] - 1).astype(np.int64).T
    colors: Pixels = image[row, column]
    return colors
