"""Whether the photographs show the points of a scene in their colours: what tells of pictures under wrong names."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from avs.scene.cameras import Cameras, FloatArray
from avs.scene.images import Pixels
from avs.scene.point_colors import pixels_of
from avs.scene.points import Points
from avs.system.lists_of_names import some_of

LEAST_CORRELATION = 0.6
"""Of the brightness of an image's points with that of its pixels. Over 459 photographs of eight real captures it was
.77 at the least and .95 in the median; with another of the same capture in its place, .01 to .37 in the median."""

_FEWEST = 30
"""Points from which a correlation tells: one of .9 comes out below .6 by chance once in 40,000 times with 30."""

_BRIGHTNESS = np.array([0.299, 0.587, 0.114])


def disagreement_note(
    names: Sequence[str], points: Points, cameras: Cameras, read: Callable[[int], Pixels]
) -> str | None:
    """Return a line about the images that do not show their points in the colours that these have, if there are any.

    A photograph that lies under the name of another, or of another capture, is whole by itself. The reconstruction then
    learns it at a pose where it was not taken, and nothing but its score would tell.

    Args:
        names: of the n images.
        points: of the scene, with the colours that they came with; black ones may have none and are passed over.
        cameras: of the n images.
        read: returns an image's pixels.
    """
    brightness = points.colors @ _BRIGHTNESS
    told = points.observations[brightness[points.observations[:, 0]] > 0]
    apart = [
        name
        for index, name in enumerate(names)
        if _disagrees(points.positions, brightness, told[told[:, 1] == index, 0], cameras[index], read, index)
    ]
    if not apart:
        return None
    return (
        f"{len(apart)} of {len(names)} photographs ({some_of(apart)}) do not show the colours of the "
        "points that they observe: they may be of other views than their names say, or masked"
    )


def _disagrees(
    positions: FloatArray,
    brightness: FloatArray,
    rows: np.ndarray,
    camera: Cameras,
    read: Callable[[int], Pixels],
    index: int,
) -> bool:
    """Whether the points ``rows`` have other brightness than the pixels they fall on; False where that is unknown."""
    if len(rows) < _FEWEST or not brightness[rows].std():
        return False
    seen = pixels_of(positions[rows], camera, read(index)) @ _BRIGHTNESS
    return not seen.std() or bool(np.corrcoef(seen, brightness[rows])[0, 1] < LEAST_CORRELATION)
