"""How much of a surface a point cloud covers, and how much of the cloud lies on it: SCR and F-score.

Distances are to the nearest point, and a point counts as near where its distance is strictly less than a threshold.
Shares are over one point for each occupied voxel, so that they are shares of surface, whatever the density of points.
No point is left out: what floats far from the reference lowers the precision.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]

ExtentDefinition = Literal["robust_box", "bounding_box"]
"""How large a cloud is: ``robust_box``, the diagonal of the box along the principal axes of the points that holds the
middle 98 % along each; ``bounding_box``, the diagonal of the box along the coordinate axes that holds all."""

MIDDLE = 0.98
"""Share of the points that a robust box holds along each axis: one point in a hundred may lie out at either end."""

_ROUNDS = 4
"""The middle is the mean of the points nearest to the middle before. The first, of all points, can lie far out."""


@dataclass(frozen=True)
class Agreement:
    """How a cloud agrees with a reference at one threshold; all in 0..1.

    Attributes:
        precision: share of the cloud that lies nearer to the reference than the threshold.
        recall: share of the reference that lies nearer to the cloud than the threshold.
        f_score: their harmonic mean; 0 where both are 0.
    """

    precision: float
    recall: float
    f_score: float


def extent(points: npt.ArrayLike, definition: ExtentDefinition = "robust_box") -> float:
    """Return the size of a cloud, in its own units.

    Args:
        points: ``[n, 3]``, at least one.
        definition: see ``ExtentDefinition``. The robust one does not change when the cloud is turned.

    Raises:
        ValueError: there is no point, or a coordinate is not finite.
    """
    cloud = _checked(points)
    if not len(cloud):
        raise ValueError("a cloud without points has no extent")
    if definition == "bounding_box":
        return float(np.linalg.norm(np.ptp(cloud, axis=0)))
    inner = cloud
    for _ in range(_ROUNDS):
        from_middle = cloud - inner.mean(axis=0)
        lengths = np.linalg.norm(from_middle, axis=1)
        inner = cloud[lengths <= np.quantile(lengths, MIDDLE)]
    spread = inner - inner.mean(axis=0)
    axes = np.linalg.svd(spread.T @ spread)[0]
    ends = np.quantile(from_middle @ axes, [0.5 - MIDDLE / 2, 0.5 + MIDDLE / 2], axis=0)
    return float(np.linalg.norm(ends[1] - ends[0]))


def representatives(points: npt.ArrayLike, voxel: float) -> IndexArray:
    """Return one point of each occupied voxel: the one nearest to the mean of the points in it.

    They are points of the cloud itself. A mean would lie beside the surface by a part of the voxel, which is more than
    the least threshold.

    Args:
        points: ``[n, 3]``.
        voxel: edge length, greater than 0.

    Returns:
        ``[m]`` rows of ``points``, ascending.
    """
    cloud = _checked(points)
    if not len(cloud):
        return np.zeros(0, dtype=np.int64)
    members, means = _voxels(cloud, voxel)
    distances = ((cloud - means[members]) ** 2).sum(axis=1)
    order = np.lexsort((distances, members))
    first = np.flatnonzero(np.diff(members[order], prepend=-1))
    return np.sort(order[first])


def voxel_means(points: npt.ArrayLike, voxel: float) -> FloatArray:
    """Return the mean ``[m, 3]`` of the points in each occupied voxel, as Open3D's down-sampling does.

    Args:
        points: ``[n, 3]``.
        voxel: edge length, greater than 0.
    """
    cloud = _checked(points)
    return _voxels(cloud, voxel)[1] if len(cloud) else cloud


def nearest_distances(points: npt.ArrayLike, targets: npt.ArrayLike) -> FloatArray:
    """Return the distance of each of the ``points`` ``[n, 3]`` to the nearest of the ``targets`` ``[m, 3]``.

    Returns:
        ``[n]`` in the units of the points; infinite where there is no target.
    """
    from scipy.spatial import KDTree  # a third of a second, which settings that name a definition above do without

    cloud, others = _checked(points), _checked(targets)
    if not len(others):
        return np.full(len(cloud), np.inf)
    return np.asarray(KDTree(others).query(cloud)[0], dtype=np.float64)


def share_nearer(distances: npt.ArrayLike, threshold: float) -> float:
    """Return the share, in 0..1, of ``distances`` ``[n]`` strictly less than a threshold; 0 where there are none.

    Of the distances of a reference to a cloud, with a threshold of 0.01 of the extent, this is the surface coverage
    ratio (SCR, section 4.3 of the paper).
    """
    values = np.asarray(distances, dtype=np.float64)
    return float((values < threshold).mean()) if len(values) else 0.0


def agreement(of_cloud: npt.ArrayLike, of_reference: npt.ArrayLike, threshold: float) -> Agreement:
    """Return precision, recall and F-score at one threshold (Knapitsch et al. 2017).

    Args:
        of_cloud: ``[n]`` distances of the cloud's points to the reference.
        of_reference: ``[m]`` distances of the reference's points to the cloud.
        threshold: in units of the distances.
    """
    precision, recall = share_nearer(of_cloud, threshold), share_nearer(of_reference, threshold)
    total = precision + recall
    return Agreement(precision, recall, 2.0 * precision * recall / total if total > 0 else 0.0)


def mean_f_score(of_cloud: npt.ArrayLike, of_reference: npt.ArrayLike, thresholds: Sequence[float]) -> float:
    """Return the mean, over thresholds, of the F-score at each, as in the paper's Table 3; see ``agreement``."""
    return float(np.mean([agreement(of_cloud, of_reference, threshold).f_score for threshold in thresholds]))


def toolbox_agreement(cloud: npt.ArrayLike, reference: npt.ArrayLike, threshold: float) -> Agreement:
    """Return precision, recall and F-score by the convention of the Tanks and Temples toolbox.

    There both clouds are replaced by the means of their points in voxels of half the threshold before distances are
    taken.

    Args:
        cloud: ``[n, 3]``.
        reference: ``[m, 3]``.
        threshold: greater than 0, in units of the points.
    """
    own, other = voxel_means(cloud, threshold / 2), voxel_means(reference, threshold / 2)
    return agreement(nearest_distances(own, other), nearest_distances(other, own), threshold)


def _voxels(cloud: FloatArray, voxel: float) -> tuple[IndexArray, FloatArray]:
    """Return the voxel ``[n]`` of each point, numbered from 0, and the mean ``[m, 3]`` of the points in each.

    The grid begins half a voxel before the least coordinates, as Open3D's does.
    """
    if not voxel > 0:
        raise ValueError(f"voxels have an edge greater than 0, not {voxel}")
    places = np.floor((cloud - cloud.min(axis=0)) / voxel + 0.5)
    members = np.zeros(len(cloud), dtype=np.int64)
    for column in places.T:  # numbers below n at every step, however far a point lies out
        _, numbers = np.unique(column, return_inverse=True)
        _, members = np.unique(members * (numbers.max() + 1) + numbers, return_inverse=True)
    sums = np.stack([np.bincount(members, weights=column) for column in cloud.T], axis=1)
    return members, sums / np.bincount(members)[:, None]


def _checked(points: npt.ArrayLike) -> FloatArray:
    cloud = np.asarray(points, dtype=np.float64)
    if cloud.ndim != 2 or cloud.shape[1] != 3 or not np.isfinite(cloud).all():
        raise ValueError(f"points of the shape {cloud.shape} must be finite numbers [n, 3]")
    return cloud
