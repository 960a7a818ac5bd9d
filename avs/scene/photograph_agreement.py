"""Whether the photographs show the points of a scene in their colours: what tells of pictures under wrong names."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from itertools import permutations

import numpy as np

from avs.scene.cameras import Cameras, FloatArray
from avs.scene.images import Pixels
from avs.scene.point_colors import pixels_of
from avs.scene.points import Points
from avs.system.lists_of_names import some_of

_LEAST_CORRELATION = {320: 0.6, 0: 0.35}
"""Of the brightness of an image's points with that of its pixels, by the longer side from which it holds, in pixels.

Over 459 photographs of eight real captures it was .77 at the least and .95 in the median; with another of the same
capture in its place, .01 to .37 in the median. A pixel of a small picture stands for points of several colours: the
same photographs have .55 at the least at 176 pixels and .42 at 96."""

_FEWEST = 30
"""Points from which a correlation tells: one of .9 comes out below .6 by chance once in 40,000 times with 30."""

_SMALLEST = 32
"""Pixels of the longer side, below which each stands for many points of several colours."""

_BRIGHTNESS = np.array([0.299, 0.587, 0.114])

# The bounds below were set with 459 photographs of eight real captures in view; what these came to stands beside each.
_ONE_COLOR = 0.2  # share of the points that fall on pixels of one and the same colour: .05 at the most
_VARIED = 8.0  # standard deviation of those points' brightness, of 255: a burnt-out sky has white points
_LEVEL = 2.0  # ratio of the means of brightness, either way: it was .85 to 1.38
_BETTER = 0.5  # by which the cosine of the chroma rises with channels exchanged: it was .51 to 1 as they are
_LEAST_CHROMA = 3.0  # root mean square, of 255, below which points are grey

_CHANNELS = "RGB"
_EXCHANGES = [order for order in permutations(range(3)) if order != (0, 1, 2)]

_MASKED = "have one and the same colour where the points that they observe have several: they may be masked or cut off"
_APART = (
    "do not show the colours of the points that they observe: they may be of other views than their names say, "
    "or masked"
)
_DARK = "are less than half as bright as the points that they observe: their scale or exposure may be another"
_BRIGHT = "are more than twice as bright as the points that they observe: their scale or exposure may be another"


def disagreement_notes(
    names: Sequence[str],
    points: Points,
    cameras: Cameras,
    read: Callable[[int], Pixels],
    cut_out: Collection[str] = (),
) -> list[str]:
    """Return a line for each way in which images do not show their points in the colours that these have.

    A photograph that lies under the name of another, has its channels exchanged, is masked, or was scaled, is whole by
    itself. The reconstruction then learns what was not there, and nothing but its score would tell.

    Args:
        names: of the n images.
        points: of the scene, with the colours that they came with; black ones may have none and are passed over.
        cameras: of the n images.
        read: returns an image's pixels.
        cut_out: names of the images that are known to be masked.
    """
    brightness = points.colors @ _BRIGHTNESS
    told = points.observations[brightness[points.observations[:, 0]] > 0]
    found: dict[str, list[str]] = {}
    for index, name in enumerate(names):
        rows = told[told[:, 1] == index, 0]
        if len(rows) < _FEWEST or not brightness[rows].std() or cameras.sizes[index].max() < _SMALLEST:
            continue
        seen = pixels_of(points.positions[rows], cameras[index], read(index)).astype(np.float64)
        least = next(value for side, value in _LEAST_CORRELATION.items() if cameras.sizes[index].max() >= side)
        fault = _fault(seen, points.colors[rows].astype(np.float64), least, name in cut_out)
        if fault is not None:
            found.setdefault(fault, []).append(name)
    return [f"{len(those)} of {len(names)} photographs ({some_of(those)}) {fault}" for fault, those in found.items()]


def _fault(seen: FloatArray, told: FloatArray, least_correlation: float, is_cut_out: bool) -> str | None:
    """Return what is wrong with a photograph, or None.

    Args:
        seen: ``[n, 3]``, the pixels that the points fall on, 0..255.
        told: ``[n, 3]``, the colours of the points, whose brightness differs.
        least_correlation: of the two brightnesses.
        is_cut_out: whether a single colour at many points is known to be a mask.
    """
    seen_light, told_light = seen @ _BRIGHTNESS, told @ _BRIGHTNESS
    if not seen_light.std():
        return _APART
    colors, counts = np.unique(seen, axis=0, return_counts=True)
    alike = (seen == colors[counts.argmax()]).all(axis=1)
    if not is_cut_out and alike.mean() > _ONE_COLOR and told_light[alike].std() > _VARIED:
        return _MASKED
    if np.corrcoef(seen_light, told_light)[0, 1] < least_correlation:
        return _APART
    exchanged = _exchanged(seen, told)
    if exchanged is not None:
        return f"have the colours of the points that they observe as {exchanged} in place of RGB"
    level = seen_light.mean() / told_light.mean()
    if level < 1 / _LEVEL:
        return _DARK
    return _BRIGHT if level > _LEVEL else None


def _exchanged(seen: FloatArray, told: FloatArray) -> str | None:
    """Return the order in which the pixels have the points' channels, such as ``BGR``; None for their own."""
    seen, told = (colors - colors.mean(axis=1, keepdims=True) for colors in (seen, told))
    least = _LEAST_CHROMA * np.sqrt(len(seen))
    sizes = [float(np.linalg.norm(chroma)) for chroma in (seen, told)]
    if min(sizes) < least:
        return None
    fits = {order: float((seen[:, order] * told).sum()) / (sizes[0] * sizes[1]) for order in _EXCHANGES}
    best = max(fits, key=fits.__getitem__)
    own = float((seen * told).sum()) / (sizes[0] * sizes[1])
    return "".join(_CHANNELS[best.index(place)] for place in range(3)) if fits[best] > own + _BETTER else None
