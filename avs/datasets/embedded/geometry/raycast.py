"""Rays against a triangle mesh, on one thread."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.geometry.mesh_model import Array
from avs.datasets.embedded.geometry.ray_search import any_triangle, first_triangles
from avs.datasets.embedded.geometry.ray_tree import build_tree
from avs.system.compatibility import import_open3d

# Rays per call. It bounds the memory of a call; larger batches are no faster.
_BATCH = 1 << 18


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
        self._corners = vertices, triangles
        self._tree = build_tree(vertices, triangles)

    def nearest(self, origins: Array, directions: Array) -> Hits:
        """Return where rays from ``origins`` along ``directions`` ``[n, 3]`` first meet the mesh.

        The search is in float32; distances and weights come from the triangle that it finds, in float64.
        """
        found = [self._met(batch, first_triangles(self._tree, batch)) for batch in _batches(origins, directions)]
        distance, triangle, weights = (np.concatenate(parts) for parts in zip(*found, strict=True))
        return Hits(distance, triangle, weights)

    def first_triangles(self, origins: Array, directions: Array) -> npt.NDArray[np.int64]:
        """Return ``Hits.triangle`` of such rays, which takes less time than all of it."""
        return np.concatenate([first_triangles(self._tree, batch) for batch in _batches(origins, directions)])

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
        return np.concatenate([any_triangle(self._tree, batch, far) for batch in _batches(origins, directions)])

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
        scene, core = self._open3d
        answer = scene.compute_distance(core.Tensor(np.asarray(points, np.float32)), nthreads=1)
        return np.asarray(answer.numpy())

    @cached_property
    def _open3d(self) -> tuple[Any, Any]:
        """Open3D's scene of the same triangles, which finds nearest points, and its ``core``."""
        core, (vertices, triangles) = import_open3d().core, self._corners
        scene = import_open3d().t.geometry.RaycastingScene(nthreads=1)
        scene.add_triangles(core.Tensor(vertices), core.Tensor(triangles.astype(np.uint32)))
        return scene, core


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
