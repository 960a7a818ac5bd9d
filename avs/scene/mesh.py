"""The mesh of a scene whose geometry is known, as a PLY file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from plyfile import PlyData

from avs.scene.similarity import Similarity


def write_moved_mesh(source: Path, target: Path, to_source: Similarity) -> None:
    """Write the mesh of ``source`` to ``target`` in other coordinates; all but the vertices' positions stays.

    Args:
        source: a PLY file with vertices x, y, z.
        target: the file to write.
        to_source: from the target's coordinates to the source's.
    """
    mesh = PlyData.read(source)
    vertices = mesh["vertex"].data
    positions = np.stack([vertices[axis] for axis in "xyz"], axis=-1).astype(np.float64)
    for axis, values in zip("xyz", to_source.points_back(positions).T, strict=True):
        vertices[axis] = values
    mesh.write(target)
