"""The mesh of a scene whose geometry is known, as a PLY file."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from plyfile import PlyData, PlyListProperty, PlyParseError

from avs.scene.similarity import Similarity

# With the length of lists known, plyfile reads them at once; else one by one, 14 microseconds each.
_TRIANGLES = {"face": {"vertex_indices": 3, "vertex_index": 3}}
_END_OF_HEADER = re.compile(rb"(?:^|[\r\n])end_header(?:\r\n|\n|\r)")


def write_moved_mesh(source: Path, target: Path, to_source: Similarity) -> None:
    """Write the mesh of ``source`` to ``target`` in other coordinates; all but the vertices' positions stays.

    Args:
        source: a PLY file with vertices x, y, z.
        target: the file to write.
        to_source: from the target's coordinates to the source's.

    Raises:
        PlyParseError: the file cannot be read.
    """
    mesh = _read(source)
    vertices = mesh["vertex"].data
    positions = np.stack([vertices[axis] for axis in "xyz"], axis=-1).astype(np.float64)
    for axis, values in zip("xyz", to_source.points_back(positions).T, strict=True):
        vertices[axis] = values
    if mesh.text or not _begins_with_vertices(mesh):
        mesh.write(target)
        return
    # What comes after the vertices is copied: plyfile writes lists one by one, too.
    content = source.read_bytes()
    header = _END_OF_HEADER.search(content)
    assert header is not None, "plyfile has read it"
    with open(target, "wb") as stream:
        stream.write(mesh.header.encode("ascii") + b"\n")
        stream.write(vertices.tobytes())
        stream.write(content[header.end() + vertices.nbytes :])


def _read(source: Path) -> PlyData:
    """Read a file of triangles quickly, and any other as plyfile does."""
    try:
        return PlyData.read(source, known_list_len=_TRIANGLES)
    except PlyParseError:
        return PlyData.read(source)


def _begins_with_vertices(mesh: PlyData) -> bool:
    """Return whether the vertices are the first element and, as usual, have numbers alone."""
    first = mesh.elements[0]
    return first.name == "vertex" and not any(isinstance(each, PlyListProperty) for each in first.properties)
