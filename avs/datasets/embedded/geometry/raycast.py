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
        """Return where rays from ``origins`` along ``directions`` ``[n, 3]`` first meet the mesh.

        Of Embree's answer the triangle alone is used. Its distances and weights have other last bits on other
        processors, because it begins with their approximate reciprocals.
        """
        found = [self._met(batch, self._triangles(batch)) for batch in _batches(origins, directions)]
        distance, triangle, weights = (np.concatenate(parts) for parts in zip(*found, strict=True))
        return Hits(distance, triangle, weights)

    def first_triangles(self, origins: Array, directions: Array) -> npt.NDArray[np.int64]:
        """Return ``Hits.triangle`` of such rays, which takes less time than all of it."""
        return np.concatenate([self._triangles(batch) for batch in _batches(origins, directions)])

    def _triangles(self, rays: Array) -> npt.NDArray[np.int64]:
        index = self._scene.cast_rays(self._core.Tensor(rays), nthreads=1)["primitive_ids"].numpy()
        return np.where(index == NOTHING, np.int64(-1), index.astype(np.int64))

    def _met(self, rays: Array, triangle: npt.NDArray[np.int64]) -> tuple[Array, npt.NDArray[np.int64], Array]:
        """Return distance, triangle and weights of rays ``[n, 6]`` with the planes of their triangles.

        As Moeller and Trumbore (1997) have it, in float64.
        """
        distance = np.full(len(rays), np.inf, np.float32)
        weights = np.tile(np.array([1, 0, 0], np.float32), (len(rays), 1))
        hit = triangle >= 0
        vertices, corners = self._corners
        first, second, third = (vertices[corners[triangle[hit], k]].astype(np.float64) for k in range(3))
        origin, direction = np.split(rays[hit].astype(np.float64), 2, axis=1)
        along, across, away = second - first, third - first, origin - first
        across_ray, across_edge = np.cross(direction, across), np.cross(away, along)
        scale = 1 / _dot(along, across_ray)
        of_second, of_third = _dot(away, across_ray) * scale, _dot(direction, across_edge) * scale
        distance[hit] = _dot(across, across_edge) * scale
        weights[hit] = np.stack([1 - of_second - of_third, of_second, of_third], axis=1)
        return distance, triangle, weights

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


def _dot(first: npt.NDArray[np.float64], second: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    # Written out: einsum and sums along an axis leave the order of the terms to the processor's vectors.
    terms = first * second
    sums: npt.NDArray[np.float64] = terms[:, 0] + terms[:, 1] + terms[:, 2]
    return sums


def _batches(origins: Array, directions: Array) -> list[Array]:
    directions = np.asarray(directions, np.float32)
    origins = np.broadcast_to(np.asarray(origins, np.float32), directions.shape)
    starts = range(0, max(len(directions), 1), _BATCH)
    return [np.concatenate([origins[i : i + _BATCH], directions[i : i + _BATCH]], axis=1) for i in starts]
