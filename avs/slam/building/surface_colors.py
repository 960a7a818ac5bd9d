"""Colours of a mesh at points of its triangles: bilinear textures times interpolated vertex colours."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.rasterizer.kernels import Floats, Integers, kernel
from avs.slam.building.building_mesh import Building, FloatArray


class SurfaceColors:
    """The colours of a building, with all textures in one array."""

    def __init__(self, building: Building) -> None:
        """Pack the textures of ``building``."""
        self._triangles = np.ascontiguousarray(building.triangles)
        self._vertex_colors = np.ascontiguousarray(building.vertex_colors)
        self._corners = np.ascontiguousarray(building.corners)
        self._texture_of = np.ascontiguousarray(building.texture_of)
        sizes = np.array([texture.shape[:2] for texture in building.textures], np.int64).reshape(-1, 2)
        starts = np.concatenate([[0], np.cumsum(sizes.prod(axis=1))[:-1]]) if len(sizes) else np.zeros(0, np.int64)
        self._places = np.concatenate([starts[:, None], sizes], axis=1).astype(np.int64)
        texels = [texture.reshape(-1, 3) for texture in building.textures]
        self._texels = np.ascontiguousarray(np.concatenate(texels)) if texels else np.zeros((0, 3), np.uint8)

    def at(self, triangles: npt.NDArray[np.int64], weights: FloatArray) -> FloatArray:
        """Return the colours ``[n, 3]`` in 0..1 at barycentric ``weights`` ``[n, 3]``; black for triangle -1."""
        colors = np.empty((len(triangles), 3), np.float32)
        _sample(
            triangles, np.ascontiguousarray(weights, np.float32), self._triangles, self._vertex_colors, self._corners,
            self._texture_of, self._places, self._texels, colors,
        )  # fmt: skip
        return colors


@kernel
def _sample(
    hit: Integers, weights: Floats, triangles: Integers, vertex_colors: Floats, corners: Floats, texture_of: Integers,
    places: Integers, texels: Integers, colors: Floats,
) -> None:  # fmt: skip
    """Fill ``colors``. A texture repeats beyond 0..1; its rows run from the top, v from the bottom."""
    for i in range(len(hit)):
        t = hit[i]
        if t < 0:
            for c in range(3):
                colors[i, c] = np.float32(0.0)
            continue
        a, b, d = weights[i, 0], weights[i, 1], weights[i, 2]
        for c in range(3):
            first, second, third = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            colors[i, c] = a * vertex_colors[first, c] + b * vertex_colors[second, c] + d * vertex_colors[third, c]
        k = texture_of[t]
        if k < 0:
            continue
        start, height, width = places[k, 0], places[k, 1], places[k, 2]
        u = a * corners[t, 0, 0] + b * corners[t, 1, 0] + d * corners[t, 2, 0]
        v = a * corners[t, 0, 1] + b * corners[t, 1, 1] + d * corners[t, 2, 1]
        x = (u - np.floor(u)) * np.float32(width) - np.float32(0.5)
        y = (np.float32(1.0) - (v - np.floor(v))) * np.float32(height) - np.float32(0.5)
        left, top = int(np.floor(x)), int(np.floor(y))
        right_share, bottom_share = x - np.float32(left), y - np.float32(top)
        row, next_row = start + (top % height) * width, start + ((top + 1) % height) * width
        column, next_column = left % width, (left + 1) % width
        for c in range(3):
            above = texels[row + column, c] * (1 - right_share) + texels[row + next_column, c] * right_share
            below = texels[next_row + column, c] * (1 - right_share) + texels[next_row + next_column, c] * right_share
            colors[i, c] *= (above * (1 - bottom_share) + below * bottom_share) * np.float32(1 / 255)
