"""Rays against a triangle mesh, by Open3D's ray casting scene (Embree), on one thread."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.geometry.mesh_model import Array
from avs.system.compatibility import import_open3d

# Rays per call. It bounds the memory of a call; larger batches are no faster.
_BATCH = 1 << 18

NOTHING = np.uint32(0xFFFFFFFF)


@dataclass(frozen=True)
class Hits:
    """First intersections of n rays.

    Attributes:
        distance: ``[n]`` in lengths of the ray's direction; infinite where the ray hits nothing.
        triangle: ``[n]`` int64, -1 where the ray hits nothing.
        weights: ``[n, 3]`` barycentric weights of the triangle's vertices.
    """

    distance: Array
    triangle: npt.NDArray[np.int64]
    weights: Array


class Caster:
    """A triangle mesh to cast rays at. Each ray is computed by itself, so that batches and threads change nothing."""

    def __init__(self, vertices: Array, triangles: npt.NDArray[np.int32]) -> None:
        """Build the search structure over ``vertices`` ``[v, 3]`` and ``triangles`` ``[t, 3]``."""
        self._core = import_open3d().core
        self._scene: Any = import_open3d().t.geometry.RaycastingScene(nthreads=1)
        self._scene.add_triangles(self._core.Tensor(vertices), self._core.Tensor(triangles.astype(np.uint32)))
        self._corners = vertices, triangles

    def nearest(self, origins: Array, directions: Array) -> Hits:
        """Return where rays from ``origins`` along ``directions`` ``[n, 3]`` first meet the mesh."""
        distance, triangle, weights = [], [], []
        for batch in _batches(origins, directions):
            answer = self._scene.cast_rays(self._core.Tensor(batch), nthreads=1)
            distance.append(answer["t_hit"].numpy())
            index = answer["primitive_ids"].numpy()
            triangle.append(np.where(index == NOTHING, np.int64(-1), index.astype(np.int64)))
            second = answer["primitive_uvs"].numpy()
            weights.append(np.concatenate([1 - second.sum(axis=1, keepdims=True), second], axis=1))
        return Hits(np.concatenate(distance), np.concatenate(triangle), np.concatenate(weights))

    def blocked(self, origins: Array, directions: Array, far: float = np.inf) -> npt.NDArray[np.bool_]:
        """Return whether anything lies on each ray before ``far`` lengths of its direction."""
        parts = [
            self._scene.test_occlusions(self._core.Tensor(batch), tnear=0.0, tfar=float(far), nthreads=1).numpy()
            for batch in _batches(origins, directions)
        ]
        return np.concatenate(parts)

    def steepness(self, triangles: npt.NDArray[np.int64]) -> Array:
        """Return the cosine ``[n]`` of the slope of triangles: 1 level, 0 upright, without area, or triangle -1."""
        vertices, corners = self._corners
        a, b, c = (vertices[corners[triangles, k]].astype(np.float64) for k in range(3))
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1)
        upward = np.abs(normal[:, 2]) / np.where(length > 0, length, 1)
        return np.where((triangles >= 0) & (length > 0), upward, 0).astype(np.float32)

    def clearance(self, points: Array) -> Array:
        """Return the distance of each point ``[n, 3]`` to the nearest surface."""
        answer = self._scene.compute_distance(self._core.Tensor(np.asarray(points, np.float32)), nthreads=1)
        return np.asarray(answer.numpy())


def _batches(origins: Array, directions: Array) -> list[Array]:
    directions = np.asarray(directions, np.float32)
    origins = np.broadcast_to(np.asarray(origins, np.float32), directions.shape)
    starts = range(0, max(len(directions), 1), _BATCH)
    return [np.concatenate([origins[i : i + _BATCH], directions[i : i + _BATCH]], axis=1) for i in starts]
