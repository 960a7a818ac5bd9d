"""Names beside points: none covers another or a point, and each is as near to its own as there is room."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_NEAREST, _STEP, _RINGS, _ANGLES = 0.05, 0.045, 26, 24  # inches, inches, and how many places are tried
_POINT = 0.035  # inches around a point that names leave free


def placed(
    points: FloatArray, sizes: FloatArray, area: tuple[float, float], kept_free: Sequence[FloatArray] = ()
) -> FloatArray:
    """Return where names go, ``[n, 2]`` lower left corners in inches.

    Places on rings around each point are tried from the nearest outwards, those at its right first; the first that is
    free is taken, or the one that covers least. Crowded points come first: they have the fewest free places.

    Args:
        points: ``[n, 2]`` in inches from the lower left corner of the plot.
        sizes: ``[n, 2]`` widths and heights of the names.
        area: width and height of the plot, which names do not leave.
        kept_free: boxes that names leave free as well: left, bottom, right and top.
    """
    corners = np.zeros_like(points)
    taken = [*kept_free, *(_box(point - _POINT, np.full(2, 2 * _POINT)) for point in points)]
    for row in _crowded_first(points):
        options = _options(points[row], sizes[row], area)
        costs = _covered(options, sizes[row], np.array(taken))
        corners[row] = options[int(np.argmin(costs))]  # the first of equal ones, which is the nearest
        taken.append(_box(corners[row], sizes[row]))
    return corners


def _crowded_first(points: FloatArray) -> list[int]:
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    order: list[int] = np.argsort(-(1.0 / (0.1 + distances)).sum(axis=1), kind="stable").tolist()
    return order


def _options(point: FloatArray, size: FloatArray, area: tuple[float, float]) -> FloatArray:
    """Return lower left corners to try, nearest first, all inside the plot."""
    angles = 2 * np.pi * np.arange(_ANGLES) / _ANGLES
    angles = angles[np.argsort(-np.cos(angles), kind="stable")]
    radii = _NEAREST + _STEP * np.arange(_RINGS)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    # The side of a name that is next to the point lies on the ring, whatever the direction.
    offsets = radii[:, None, None] * directions[None] + (directions[None] - 1) * size / 2
    corners = (point + offsets).reshape(-1, 2)
    return np.asarray(np.clip(corners, 0.0, np.maximum(0.0, np.array(area) - size)))


def _covered(corners: FloatArray, size: FloatArray, taken: FloatArray) -> FloatArray:
    """Return how much of what is taken a name would cover at each of the corners, in square inches."""
    low = np.maximum(corners[:, None], taken[None, :, :2])
    high = np.minimum(corners[:, None] + size, taken[None, :, 2:])
    return np.asarray(np.round(np.clip(high - low, 0.0, None).prod(axis=2).sum(axis=1), 9))


def _box(corner: FloatArray, size: FloatArray) -> FloatArray:
    return np.concatenate([corner, corner + size])
