"""Initial points of the Gaussians: random, or from structure from motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.rasterizer.nearest_points import nearest_distances
from avs.representations.gaussians.gaussian_settings import ExtentChoice, InitialPoints
from avs.scene.cameras import IndexArray
from avs.scene.normalisation import camera_ball
from avs.scene.scene import Points, Scene
from avs.system.errors import UserError

NEIGHBOURS = 3
"""The initial scale is the distance to this many nearest points, as in 3DGS."""

MANY_POINTS = 10_000
"""With more points than this a KD-tree is worth its import, which takes 0.2 to 0.3 s."""

LEAST_SQUARED_DISTANCE = 1e-7
"""In square scene units."""

DARKEST = 0.5 / 255
"""Least initial colour. A point of colour 0 would be held there, where it has no gradient, and never learn another; its
8 bits stand for all that is darker than this."""

SH_DEGREE_0 = 0.28209479177387814
"""Value of the spherical harmonic of degree 0: 1 / (2 sqrt(pi))."""


Ball = tuple[npt.NDArray[np.float64], float]
"""The middle ``[3]`` of a scene, and its extent."""


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
    scene: Scene, ball: Ball, captured: IndexArray, settings: InitialPoints, generator: np.random.Generator
) -> PointCloud:
    """Return the points that the Gaussians start from.

    ``random`` draws positions uniformly from a cube around the cameras of the scene, and near-grey colours as 3DGS does
    for its synthetic scenes. It uses no image; the poses of candidates are known in active view selection.

    Args:
        scene: cameras and points.
        ball: the middle of the scene and its extent.
        captured: indices of the captured images.
        settings: the choice and its numbers.
        generator: source of random positions and colours.

    Raises:
        UserError: the choice leaves fewer points than the three neighbours of one point need.
    """
    if settings.choice == "random":
        return _random_points(ball, settings, generator)
    points = scene.points
    rows = np.arange(len(points))
    if settings.choice == "selected":
        rows = seen_points(points, captured, settings.selected_min_views)
    if len(rows) <= NEIGHBOURS:
        fault = f"{len(rows)} of {len(points)} points of structure from motion are left for points '{settings.choice}'"
        enough = ("sfm", "random") if len(points) > NEIGHBOURS else ("random",)
        remedy = f"set representation: {{points: {{choice: {' or '.join(enough)}}}}}, or add points to the model"
        raise UserError(scene.folder, fault, remedy)
    if settings.max_count is not None and len(rows) > settings.max_count:
        rows = np.sort(generator.choice(rows, settings.max_count, replace=False))
    return PointCloud(points.positions[rows], points.colors[rows] / 255.0)


def reference_ball(scene: Scene, extent: ExtentChoice) -> Ball:
    """Return the ball that rates, thresholds and random points are relative to."""
    if extent == "all_cameras":
        return camera_ball(scene.cameras.centers[scene.pool])
    return np.zeros(3), scene.extent


def seen_points(points: Points, images: IndexArray, min_views: int) -> IndexArray:
    """Return the rows of ``points`` that at least ``min_views`` of ``images`` see, ascending."""
    seen = points.observations[np.isin(points.observations[:, 1], images)]
    # An image may hold several observations of one point; each image counts once.
    counts = np.bincount(np.unique(seen, axis=0)[:, 0], minlength=len(points))
    return np.flatnonzero(counts >= min_views)


def initial_scales(positions: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return ``[p]`` scales: the root mean square distance to the three nearest other points (3DGS, section 5.1).

    Coincident points get the lower bound of the 3DGS code, the root of ``LEAST_SQUARED_DISTANCE``.
    """
    distances = (_tree_distances if len(positions) > MANY_POINTS else nearest_distances)(positions)
    squared: npt.NDArray[np.float64] = np.mean(distances**2, axis=1)
    return np.sqrt(np.maximum(squared, LEAST_SQUARED_DISTANCE))


def _tree_distances(positions: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Do what ``nearest_distances`` does, by a KD-tree.

    A leaf of the tree cannot be split where points coincide, and would be searched whole for each of them. Of those
    that do, as many as there are neighbours and one more tell all there is to know.
    """
    from scipy.spatial import cKDTree

    order = np.lexsort(positions.T)
    places = positions[order]
    same = (places[NEIGHBOURS + 1 :] == places[: -NEIGHBOURS - 1]).all(axis=1)
    distances, _ = cKDTree(places[~np.concatenate([np.zeros(NEIGHBOURS + 1, dtype=bool), same])]).query(
        positions, k=NEIGHBOURS + 1
    )
    others: npt.NDArray[np.float64] = distances[:, 1:]
    return others


def _random_points(ball: Ball, settings: InitialPoints, generator: np.random.Generator) -> PointCloud:
    middle, extent = ball
    half = settings.random_bounds * extent
    offsets = generator.uniform(-half, half, (settings.random_count, 3))
    # 3DGS draws harmonic coefficients from U(0, 1/255): colours within 0.0012 of mid grey.
    coefficients = generator.uniform(0, 1 / 255, (settings.random_count, 3))
    return PointCloud(middle + offsets, 0.5 + SH_DEGREE_0 * coefficients)
