"""A building as one triangle mesh with its colours: what every reader of meshes returns."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float32]
Texture = npt.NDArray[np.uint8]

GREY = 0.6
"""Colour, in 0..1, of a surface that has neither a texture nor vertex colours."""


@dataclass(frozen=True)
class Building:
    """A triangle mesh; once ``upright`` (see ``building_frame``) in metres, z upwards.

    Attributes:
        vertices: ``[v, 3]`` float32.
        triangles: ``[t, 3]`` int32 vertex indices.
        vertex_colors: ``[v, 3]`` float32 sRGB in 0..1, which textures are multiplied with; 1 where a texture alone
            counts, ``GREY`` where nothing is known.
        corners: ``[t, 3, 2]`` float32 texture coordinates of the triangles' corners; v runs upwards from the last row.
        texture_of: ``[t]`` int32 index of ``textures``, -1 for a triangle without one.
        textures: ``[height, width, 3]`` uint8 sRGB each, rows from the top.
        notes: what a reader of results should know of this mesh, without a full stop.
    """

    vertices: FloatArray
    triangles: npt.NDArray[np.int32]
    vertex_colors: FloatArray
    corners: FloatArray
    texture_of: npt.NDArray[np.int32]
    textures: tuple[Texture, ...]
    notes: tuple[str, ...] = ()

    def noted(self, *notes: str) -> Building:
        """Return the same building with more notes."""
        return replace(self, notes=(*self.notes, *notes))

    @property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """The least and the greatest coordinates ``[3]`` of all corners of triangles."""
        used = self.vertices[np.unique(self.triangles)]
        return used.min(axis=0), used.max(axis=0)


def joined(parts: list[Building]) -> Building:
    """Return one building of several parts; a texture belongs to its part."""
    first_vertex = np.cumsum([0, *(len(part.vertices) for part in parts)])
    first_texture = np.cumsum([0, *(len(part.textures) for part in parts)])
    return Building(
        vertices=np.concatenate([part.vertices for part in parts]),
        triangles=np.concatenate([part.triangles + n for part, n in zip(parts, first_vertex, strict=False)]).astype(
            np.int32
        ),
        vertex_colors=np.concatenate([part.vertex_colors for part in parts]),
        corners=np.concatenate([part.corners for part in parts]),
        texture_of=np.concatenate(
            [np.where(p.texture_of < 0, -1, p.texture_of + n) for p, n in zip(parts, first_texture, strict=False)]
        ).astype(np.int32),
        textures=tuple(texture for part in parts for texture in part.textures),
        notes=tuple(dict.fromkeys(note for part in parts for note in part.notes)),
    )
