"""Initial points of the Gaussians: random, or from structure from motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.rasterizer.nearest_points import nearest_distances
from avs.representations.gaussians.gaussian_settings import InitialPoints
from avs.scene.cameras import IndexArray
from avs.scene.scene import Points, Scene
from avs.system.errors import UserError

NEIGHBOURS = 3
"""The initial scale is the distance to this many nearest points, as in 3DGS."""

MANY_POINTS = 10_000
"""With more points than this a KD-tree is worth its import, which takes 0.2 to 0.3 s."""

SH_DEGREE_0 = 0.28209479177387814
"""Value of the spherical harmonic of degree 0: 1 / (2 sqrt(pi))."""


@dataclass(frozen=True)
class PointCloud:
    """Points with colours.

    Attributes:
        positions: ``[p, 3]`` float64, world coordinates.
        colors: ``[p, 3]`` float64, sRGB in 0..1.
    """

    positions: npt.NDArray[np.float64]
    colors: npt.NDArray[np.float64]


def initial_points(
    scene: Scene, captured: IndexArray, settings: InitialPoints, generator: np.random.Generator
) -> PointCloud:
    """Return the points that the Gaussians start from.

    ``random`` draws positions uniformly from a cube around the mean of all camera centres of the scene, and near-grey
    colours as 3DGS does for its synthetic scenes. It uses no image; the poses of candidates are known in active view
    selection.

    Args:
        scene: cameras and points.
        captured: indices of the captured images.
        settings: the choice and its numbers.
        generator: source of random positions and colours.

    Raises:
        UserError: the choice leaves fewer points than the three neighbours of one point need.
    """
    if settings.choice == "random":
        return _random_points(scene, settings, generator)
    points = scene.points
    rows = np.arange(len(points))
    if settings.choice == "selected":
        rows = seen_points(points, captured, settings.selected_min_views)
    if len(rows) <= NEIGHBOURS:
        raise UserError(
            scene.folder,
            f"{len(rows)} of {len(points)} points of structure from motion are left for points '{settings.choice}'",
            "choose points 'random', or add points to the model",
        )
    if settings.max_count is not None and len(rows) > settings.max_count:
        rows = np.sort(generator.choice(rows, settings.max_count, replace=False))
    return PointCloud(points.positions[rows], points.colors[rows] / 255.0)


def seen_points(points: Points, images: IndexArray, min_views: int) -> IndexArray:
    """Return the rows of ``points`` that at least ``min_views`` of ``images`` see, ascending."""
    seen = points.observations[np.isin(points.observations[:, 1], images)]
    # An image may hold several observations of one point; each image counts once.
    counts = np.bincount(np.unique(seen, axis=0)[:, 0], minlength=len(points))
    return np.flatnonzero(counts >= min_views)


def initial_scales(positions: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return ``[p]`` scales: the root mean square distance to the three nearest other points (3DGS, section 5.1).

    Coincident points get a scale of sqrt(1e-7), the lower bound of the 3DGS code.
    """
    distances = (_tree_distances if len(positions) > MANY_POINTS else nearest_distances)(positions)
    squared: npt.NDArray[np.float64] = np.mean(distances**2, axis=1)
    return np.sqrt(np.maximum(squared, 1e-7))


def _tree_distances(positions: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Do what ``nearest_distances`` does, by a KD-tree."""
    from scipy.spatial import cKDTree

    distances, _ = cKDTree(positions).query(positions, k=NEIGHBOURS + 1)
    others: npt.NDArray[np.float64] = distances[:, 1:]
    return others


def _random_points(scene: Scene, settings: InitialPoints, generator: np.random.Generator) -> PointCloud:
    half = settings.random_bounds * scene.extent
    offsets = generator.uniform(-half, half, (settings.random_count, 3))
    # 3DGS draws harmonic coefficients from U(0, 1/255): colours within 0.0012 of mid grey.
    coefficients = generator.uniform(0, 1 / 255, (settings.random_count, 3))
    return PointCloud(scene.cameras.centers.mean(axis=0) + offsets, 0.5 + SH_DEGREE_0 * coefficients)
