"""What a camera does to its pictures: field of view, exposure, and how much darker they are towards the corners."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, FloatArray

RINGS = 16
"""Parts of the way from the centre of a picture to its corner, in which luminance is measured."""

_WEIGHTS = np.array([0.2126, 0.7152, 0.0722])  # of red, green and blue in the luminance of sRGB (ITU-R BT.709)


@dataclass(frozen=True)
class Characteristics:
    """Means over the photographs of a scene.

    Attributes:
        field_of_view: horizontal and vertical, in degrees.
        luminance: mean over all pixels in 0..1, in linear light.
        rings: ``[RINGS]`` mean luminance by distance to the centre, in linear light; the last ring ends in the corner.
    """

    field_of_view: tuple[float, float]
    luminance: float
    rings: FloatArray


def characteristics(cameras: Cameras, photographs: Sequence[npt.NDArray[np.uint8]]) -> Characteristics:
    """Return what photographs ``[height, width, 3]``, sRGB, with these cameras have in common."""
    focal = cameras.intrinsics[:, [0, 1], [0, 1]]
    middle = cameras.intrinsics[:, :2, 2]
    low, high = np.arctan2(middle, focal), np.arctan2(cameras.sizes - middle, focal)
    across, up = np.degrees(low + high).mean(axis=0).tolist()
    lights = [linear_luminance(photograph) for photograph in photographs]
    rings = np.mean([_by_ring(light) for light in lights], axis=0)
    return Characteristics((across, up), float(np.mean([light.mean() for light in lights])), rings)


def linear_luminance(photograph: npt.NDArray[np.uint8]) -> FloatArray:
    """Return the luminance ``[height, width]`` in 0..1 of an sRGB image, in linear light (IEC 61966-2-1)."""
    values = photograph / 255.0
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    return np.asarray(linear @ _WEIGHTS)


def _by_ring(light: FloatArray) -> FloatArray:
    """Return the mean luminance of each ring around the centre of a picture."""
    height, width = light.shape
    rows, columns = np.mgrid[:height, :width]
    distance = np.hypot(rows - (height - 1) / 2, columns - (width - 1) / 2)
    ring = np.minimum((RINGS * distance / distance.max()).astype(int), RINGS - 1)
    counts = np.bincount(ring.ravel(), minlength=RINGS)
    sums = np.bincount(ring.ravel(), weights=light.ravel(), minlength=RINGS)
    means = sums / np.maximum(counts, 1)
    # A small picture has no pixel in some rings: they have the value of the nearest ring inwards, or outwards.
    filled = np.flatnonzero(counts)
    return np.asarray(np.interp(np.arange(RINGS), filled, means[filled]))
