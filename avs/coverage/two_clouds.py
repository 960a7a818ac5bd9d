"""A cloud held against what it should cover: distances both ways, and the numbers that follow from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from avs.coverage.coverage_record import AtThreshold, Numbers
from avs.coverage.coverage_settings import CoverageJob
from avs.coverage.reference_cloud import ReferenceFiles
from avs.scene.cameras import FloatArray, IndexArray
from metrics.coverage import (
    agreement,
    mean_f_score,
    nearest_distances,
    representatives,
    share_nearer,
    toolbox_agreement,
)


@dataclass(frozen=True)
class Side:
    """What clouds are held against.

    Attributes:
        points: ``[n, 3]``, all of them.
        rows: ``[m]``, one point for each voxel: what is to be covered.
        voxel: edge length, in units of the points.
    """

    points: FloatArray
    rows: IndexArray
    voxel: float


@dataclass(frozen=True)
class Distances:
    """Of a cloud and what it is held against, both ways, in units of the points.

    Attributes:
        of_cloud: ``[k]``, of each point of the cloud to the nearest of all points of the other.
        of_side: ``[m]``, of one point of the other for each voxel to the nearest of the cloud.
    """

    of_cloud: FloatArray
    of_side: FloatArray


def sides_of(reference: ReferenceFiles, voxel: float) -> Mapping[str, Side]:
    """Return what clouds are held against, by the name of the record's field; nothing if the reference has no extent.

    There is no true surface to cover where images are coarser than voxels all over it.

    Args:
        reference: of the scene.
        voxel: edge of the voxels, in extents.
    """
    size = reference.record.extent
    if size is None:
        return {}
    edge = voxel * size
    sides = {"against_reference": _side(reference.cloud.positions, np.arange(len(reference.cloud)), edge)}
    if reference.surface is not None:
        fine = np.flatnonzero(reference.surface_cloud.confidence >= 1)
        if len(fine):
            sides["against_surface"] = _side(reference.surface, fine, edge)
    return sides


def _side(points: FloatArray, counted: IndexArray, voxel: float) -> Side:
    """Return what clouds are held against, of which the rows in ``counted`` are to be covered."""
    return Side(points, counted[representatives(points[counted], voxel)], voxel)


def held_against(side: Side, cloud: FloatArray) -> Distances:
    """Return the distances between a cloud ``[k, 3]`` and what it is held against."""
    return Distances(nearest_distances(cloud, side.points), nearest_distances(side.points[side.rows], cloud))


def share_covered(side: Side, cloud: FloatArray, threshold: float) -> float:
    """Return the SCR of a cloud ``[k, 3]``, in 0..1, at a threshold in units of the points."""
    return share_nearer(nearest_distances(side.points[side.rows], cloud), threshold)


def numbers(side: Side, cloud: FloatArray, distances: Distances, settings: CoverageJob, extent: float) -> Numbers:
    """Return how a cloud covers what it is held against.

    Args:
        side: what it is held against.
        cloud: ``[k, 3]``.
        distances: between the two.
        settings: thresholds, in extents.
        extent: in units of the points.
    """
    of_cloud = distances.of_cloud[representatives(cloud, side.voxel)]
    thresholds = [share * extent for share in settings.thresholds]
    found = [(share, agreement(of_cloud, distances.of_side, share * extent)) for share in settings.thresholds]
    return Numbers(
        scr=share_nearer(distances.of_side, settings.threshold * extent),
        f_score=mean_f_score(of_cloud, distances.of_side, thresholds),
        toolbox_f_score=toolbox_agreement(cloud, side.points, settings.threshold * extent).f_score,
        at=[
            AtThreshold(threshold=share, precision=each.precision, recall=each.recall, f_score=each.f_score)
            for share, each in found
        ],
    )
