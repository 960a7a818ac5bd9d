"""Sparse models of views, with known or free poses: the cloud, the views that are in it, and who sees which point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from avs.scene.points import Points
from avs.scene.views import Views
from avs.sfm.cloud import empty_cloud
from avs.sfm.colmap_workspace import cameras_of_model, cloud_of, row_of, workspace
from avs.sfm.reconstruction import Reconstruction
from avs.sfm.sfm_settings import FeatureSettings
from avs.sfm.sparse import find_features, map_incrementally, match_free, match_known, triangulate


@dataclass(frozen=True)
class SparseModel:
    """A reconstruction, and its points once more with who sees them.

    Attributes:
        reconstruction: as a back end gives it.
        points: those of the cloud; image indices count the views of ``reconstruction.registered``.
    """

    reconstruction: Reconstruction
    points: Points


def triangulated(views: Views, settings: FeatureSettings, seed: int) -> SparseModel:
    """Return the sparse model of views whose poses are known; one that shares no point with others is left out."""
    with workspace(views) as folder:
        database = find_features(folder, views.cameras, settings)
        match_known(database, views.cameras, settings)
        model = triangulate(folder, database, views.cameras, settings, seed)
    seen = sorted({row for point in model.points3D.values() for row in _rows(point, model)})
    lost = {name: "shares no point with another view" for row, name in enumerate(views.names) if row not in seen}
    names = tuple(views.names[row] for row in seen)
    return SparseModel(Reconstruction(cloud_of(model), names, lost), _points(model, seen))


def mapped(views: Views, settings: FeatureSettings, seed: int) -> SparseModel:
    """Return the sparse model of views whose poses are found with it: of several models that with the most views."""
    with workspace(views) as folder:
        database = find_features(folder, views.cameras, settings)
        match_free(database, settings, seed)
        models = map_incrementally(folder, database, seed)
        rows = sorted(row_of(image.name) for image in models[0].images.values() if image.has_pose) if models else []
        reason = "was not registered by incremental mapping"
        lost = {name: reason for row, name in enumerate(views.names) if row not in rows}
        names = tuple(views.names[row] for row in rows)
        if not models:
            return SparseModel(Reconstruction(empty_cloud(), names, lost, views.cameras[rows]), _no_points())
        cameras = cameras_of_model(models[0], rows, views)
        notes = (f"{len(models)} models that do not connect: the largest was taken",) if len(models) > 1 else ()
        return SparseModel(Reconstruction(cloud_of(models[0]), names, lost, cameras, notes), _points(models[0], rows))


def _points(model: Any, rows: list[int]) -> Points:  # noqa: ANN401 - pycolmap has no types
    """Return the points in the order of ``cloud_of``, seen by places in ``rows``."""
    place = {row: index for index, row in enumerate(rows)}
    cloud = cloud_of(model)
    observations = [
        (number, place[row])
        for number, identifier in enumerate(sorted(model.points3D))
        for row in sorted(_rows(model.points3D[identifier], model))
    ]
    return Points(cloud.positions, cloud.colors, np.array(observations, dtype=np.int64).reshape(-1, 2))


def _no_points() -> Points:
    cloud = empty_cloud()
    return Points(cloud.positions, cloud.colors, np.zeros((0, 2), dtype=np.int64))


def _rows(point: Any, model: Any) -> set[int]:  # noqa: ANN401
    return {row_of(model.images[element.image_id].name) for element in point.track.elements}
