"""Which views a depth map is compared with, and between which depths it lies: both from sparse points."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, FloatArray, IndexArray
from avs.scene.points import Points

BEST_ANGLE, NARROW, WIDE = 10.0, 5.0, 20.0
"""Degrees between two rays to a point that suit stereo best, and how fast narrower and wider ones suit it less: narrow
ones see little depth, wide ones show another side of the surface."""

ENOUGH = 20
"""Points of a view that tell its depths; with fewer, all points that its picture could show are asked too."""

STRAY = 3.0
"""Percent of the points at either end of the depths that may be wrong."""

NEAREST_SHARE, FARTHEST_SHARE = 0.65, 2.5
"""How far beyond the other points' depths the surface may lie: nearer and farther, as factors."""


def visible(positions: FloatArray, cameras: Cameras) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    """Return the depths ``[n, p]`` of points in n cameras, and which lie before a camera and inside its picture."""
    transforms = cameras.world_to_camera
    local = np.einsum("nij,pj->npi", transforms[:, :3, :3], positions) + transforms[:, None, :3, 3]
    depths = local[..., 2]
    projected = np.einsum("nij,npj->npi", cameras.intrinsics, local)
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = projected[..., :2] / projected[..., 2:]
    inside = (depths > 0) & (pixels >= 0).all(axis=-1) & (pixels < cameras.sizes[:, None]).all(axis=-1)
    return depths, inside


def source_views(points: Points, cameras: Cameras, count: int) -> list[IndexArray]:
    """Return for each view the ``count`` others that suit stereo with it best, the best first.

    Each point of a view that another could see counts for it by the angle between the two rays. Views that could see
    nothing in common are no sources, so that a view may have fewer.
    """
    sources = []
    for row, here in enumerate(_points_of(points, cameras)):
        others = np.delete(np.arange(len(cameras)), row)
        positions = points.positions[here]
        rays = _directions(positions - cameras.centers[row])
        _, inside = visible(positions, cameras[others])
        towards = _directions(positions[None] - cameras.centers[others][:, None])
        angles = np.degrees(np.arccos(np.clip((towards * rays).sum(axis=-1), -1, 1)))
        scores = (_suitability(angles) * inside).sum(axis=1)
        order = np.argsort(-scores, kind="stable")[:count]
        sources.append(others[order[scores[order] > 0]].astype(np.int64))
    return sources


def inverse_depths(points: Points, cameras: Cameras) -> FloatArray:
    """Return the least and greatest inverse depth ``[n, 2]`` at which each view may show a surface.

    A view that no point tells of gets those of all views together, or NaN if there is no point at all.
    """
    ranges = np.full((len(cameras), 2), np.nan)
    for row in range(len(cameras)):
        depths, inside = visible(points.positions, cameras[row])
        if inside.any():
            near, far = np.percentile(depths[inside], [STRAY, 100 - STRAY])
            ranges[row] = 1 / (FARTHEST_SHARE * far), 1 / (NEAREST_SHARE * near)
    unknown = np.isnan(ranges[:, 0])
    if not unknown.all():
        ranges[unknown] = ranges[~unknown, 0].min(), ranges[~unknown, 1].max()
    return ranges


def _points_of(points: Points, cameras: Cameras) -> list[IndexArray]:
    """Return the rows of the points that each view sees, or of those that it could see where it sees few."""
    found = []
    for row in range(len(cameras)):
        seen = points.observations[points.observations[:, 1] == row, 0]
        if len(seen) < ENOUGH:
            _, inside = visible(points.positions, cameras[row])
            seen = np.flatnonzero(inside[0])
        found.append(seen)
    return found


def _suitability(angles: FloatArray) -> FloatArray:
    """Return how well angles in degrees suit stereo, in 0..1."""
    width = np.where(angles < BEST_ANGLE, NARROW, WIDE)
    suitability: FloatArray = np.exp(-0.5 * ((angles - BEST_ANGLE) / width) ** 2)
    return suitability


def _directions(vectors: FloatArray) -> FloatArray:
    directions: FloatArray = vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)
    return directions
