"""A moved mesh is what plyfile writes of it, whatever the file's form."""

import numpy as np
import pytest
from plyfile import PlyData, PlyElement, PlyParseError

from avs.scene.mesh import write_moved_mesh
from avs.scene.similarity import Similarity

MOVE = Similarity(scale=2.0, translation=(1.0, -2.0, 0.5))


def elements(polygons, vertices_first=True):
    """Return six coloured vertices, and faces with a number of their own."""
    rng = np.random.default_rng(0)
    vertices = np.zeros(6, [("x", "f4"), ("y", "f4"), ("z", "f4"), ("red", "u1")])
    for axis in "xyz":
        vertices[axis] = rng.normal(size=6)
    vertices["red"] = range(6)
    # One byte, because beside lists plyfile writes longer numbers in the machine's order.
    faces = np.empty(len(polygons), [("vertex_indices", "O"), ("material", "u1")])
    for row, polygon in enumerate(polygons):
        faces[row] = (np.array(polygon, "i4"), row)
    found = [
        PlyElement.describe(vertices, "vertex", comments=["made by hand"]),
        PlyElement.describe(faces, "face", val_types={"vertex_indices": "i4"}, len_types={"vertex_indices": "u1"}),
    ]
    return found if vertices_first else found[::-1]


def moved_by_plyfile(source, target):
    mesh = PlyData.read(source)
    data = mesh["vertex"].data
    positions = np.stack([data[axis] for axis in "xyz"], axis=-1).astype(np.float64)
    for axis, values in zip("xyz", MOVE.points_back(positions).T, strict=True):
        data[axis] = values
    mesh.write(target)


@pytest.mark.parametrize("form", [{"text": True}, {"byte_order": "<"}, {"byte_order": ">"}], ids=str)
@pytest.mark.parametrize("polygons", [[(0, 1, 2), (3, 4, 5)], [(0, 1, 2, 3), (3, 4, 5)], []], ids=str)
@pytest.mark.parametrize("vertices_first", [True, False])
def test_all_but_the_positions_stays(form, polygons, vertices_first, tmp_path):
    PlyData(elements(polygons, vertices_first), **form).write(tmp_path / "mesh.ply")
    before = (tmp_path / "mesh.ply").read_bytes()
    write_moved_mesh(tmp_path / "mesh.ply", tmp_path / "moved.ply", MOVE)
    moved_by_plyfile(tmp_path / "mesh.ply", tmp_path / "expected.ply")
    assert (tmp_path / "moved.ply").read_bytes() == (tmp_path / "expected.ply").read_bytes()
    assert (tmp_path / "mesh.ply").read_bytes() == before


def test_a_file_that_is_cut_off_is_refused(tmp_path):
    PlyData(elements([(0, 1, 2), (3, 4, 5)]), byte_order="<").write(tmp_path / "mesh.ply")
    (tmp_path / "mesh.ply").write_bytes((tmp_path / "mesh.ply").read_bytes()[:-3])
    with pytest.raises(PlyParseError):
        write_moved_mesh(tmp_path / "mesh.ply", tmp_path / "moved.ply", MOVE)
    assert not (tmp_path / "moved.ply").exists()
