"""Five numbers that say what a reconstruction holds in front of a camera, and how far captured views are from it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.representations.base import Rendering
from avs.scene.cameras import Cameras

FloatArray = npt.NDArray[np.float64]

VIEW_GEOMETRY = ("opacity", "depth", "depth_spread", "distance", "angle")
"""Their names, in order."""


def view_geometry(rendering: Rendering, cameras: Cameras, captured: Cameras) -> FloatArray:
    """Return what is known of each view beside its pixels.

    ``opacity`` is the mean accumulated opacity in 0..1. ``depth`` and ``depth_spread`` are mean and standard deviation
    of the logarithm of the depth, weighted by opacity, 0 where nothing is seen; depths are in scene units, of which
    every scene's extent has five. ``distance`` is that to the nearest captured camera, in the same units, and ``angle``
    the least one between its viewing direction and a captured one, radians.

    Args:
        rendering: of n cameras.
        cameras: the same n cameras.
        captured: m cameras whose photographs the reconstruction has seen, m >= 1.

    Returns:
        ``[n, 5]``, finite; columns as ``VIEW_GEOMETRY``.
    """
    weights = rendering.alpha.astype(np.float64) * (rendering.depth > 0.0)
    logarithms = np.log(np.where(rendering.depth > 0.0, rendering.depth, 1.0), dtype=np.float64)
    total = np.maximum(weights.sum(axis=(1, 2)), np.finfo(np.float64).tiny)
    depth = (weights * logarithms).sum(axis=(1, 2)) / total
    variance = (weights * (logarithms - depth[:, None, None]) ** 2).sum(axis=(1, 2)) / total
    apart = np.linalg.norm(cameras.centers[:, None] - captured.centers[None], axis=2)
    cosines = _directions(cameras) @ _directions(captured).T
    return np.stack(
        [
            rendering.alpha.mean(axis=(1, 2), dtype=np.float64),
            depth,
            np.sqrt(variance),
            apart.min(axis=1),
            np.arccos(np.clip(cosines, -1.0, 1.0)).min(axis=1),
        ],
        axis=1,
    )


def _directions(cameras: Cameras) -> FloatArray:
    """Return the unit viewing directions in the world, ``[n, 3]``."""
    directions: FloatArray = cameras.world_to_camera[:, 2, :3]
    return directions
