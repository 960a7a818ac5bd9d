"""Files that a mesh names are part of what an exploration was made of."""

import json
import struct

import numpy as np
import pytest
from PIL import Image

from avs.slam.building.building_files import read_building
from avs.slam.building.side_files import mesh_digest, side_files
from avs.system.files import file_hash


@pytest.fixture
def obj(tmp_path):
    (tmp_path / "a.obj").write_text("# a mesh\nmtllib a.mtl\nv 0 0 0\n")
    (tmp_path / "a.mtl").write_text("newmtl one\nKd 1 1 1\nmap_Kd -s 1 1 1 wall.png\nmap_Bump gone.png\n")
    (tmp_path / "wall.png").write_bytes(b"picture")
    return tmp_path / "a.obj"


def test_materials_and_textures_of_obj_are_found(obj):
    assert [path.name for path in side_files(obj)] == ["a.mtl", "wall.png"]


def test_buffers_and_textures_of_gltf_are_found(tmp_path):
    told = {
        "buffers": [{"uri": "a%20b.bin"}, {"uri": "data:;base64,AA"}],
        "images": [{"uri": "t.jpg"}, {"bufferView": 0}],
    }
    (tmp_path / "a.gltf").write_text(json.dumps(told))
    for name in ("a b.bin", "t.jpg"):
        (tmp_path / name).write_bytes(b"x")
    assert [path.name for path in side_files(tmp_path / "a.gltf")] == ["a b.bin", "t.jpg"]


MATERIAL = "newmtl one\nKd 1 1 1\n"


def write_obj(folder, named, texture, library, file):
    """Write a triangle with a texture: what follows ``mtllib`` and ``map_Kd``, and the names of the two files."""
    faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl one\nf 1/1 2/2 3/3\n"
    for path in (folder / library, folder / file):
        path.parent.mkdir(parents=True, exist_ok=True)
    (folder / "a.obj").write_text(f"{named}\n{faces}")
    (folder / library).write_text(f"{MATERIAL}{texture}\n")
    Image.fromarray(np.full((4, 4, 3), 200, np.uint8)).save(folder / file)
    return folder / "a.obj"


@pytest.mark.parametrize(
    ("named", "texture", "library", "file"),
    [
        ("mtllib a.mtl", "map_Kd wall.png", "a.mtl", "wall.png"),
        ("mtllib a.mtl", "map_Kd wall paper.png", "a.mtl", "wall paper.png"),
        ("mtllib a.mtl", "map_Kd -s 1 1 1 -clamp on wall  paper.png", "a.mtl", "wall  paper.png"),
        ("mtllib a.mtl", "map_Kd t\\wall.png", "a.mtl", "t/wall.png"),
        ("mtllib a.mtl", "map_Kd C:\\somewhere\\wall.png", "a.mtl", "wall.png"),
        ("mtllib a.mtl", "map_Kd\t/somewhere/wall.png", "a.mtl", "wall.png"),
        ("mtllib\ta.mtl", "map_Kd\twall.png", "a.mtl", "wall.png"),
        ("mtllib a b.mtl", "map_Kd wall.png", "a b.mtl", "wall.png"),
        ("mtllib m/a.mtl", "map_Kd wall.png", "m/a.mtl", "m/wall.png"),
        ("mtllib gone.mtl", "map_Kd wall.png", "a.mtl", "wall.png"),
        ("#\n" * 800_000 + "mtllib a.mtl", "map_Kd wall.png", "a.mtl", "wall.png"),
    ],
)
def test_what_open3d_takes_for_a_texture_is_found(tmp_path, named, texture, library, file):
    path = write_obj(tmp_path, named, texture, library, file)
    assert len(read_building(path).textures) == 1
    assert [tmp_path / library, tmp_path / file] == side_files(path)


@pytest.mark.parametrize("named", ["mtllib b.mtl a.mtl", "mtllib b.mtl\nmtllib a.mtl", "mtllib  b.mtl  a.mtl "])
def test_several_libraries_are_found(tmp_path, named):
    path = write_obj(tmp_path, named, "map_Kd wall.png", "a.mtl", "wall.png")
    (tmp_path / "b.mtl").write_text("newmtl two\n")
    assert {each.name for each in side_files(path)} == {"a.mtl", "b.mtl", "wall.png"}


def test_textures_beside_a_binary_gltf_are_found(tmp_path):
    told = json.dumps({"images": [{"uri": "t.jpg"}]}).encode()
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(told), len(told), 0x4E4F534A)
    (tmp_path / "a.glb").write_bytes(head + told)
    (tmp_path / "t.jpg").write_bytes(b"x")
    assert [path.name for path in side_files(tmp_path / "a.glb")] == ["t.jpg"]
    (tmp_path / "a.glb").write_bytes(b"glTF")
    assert side_files(tmp_path / "a.glb") == []


@pytest.mark.parametrize("content", ["not json", "[]", '{"buffers": 3}', '{"images": [{"uri": 3}]}'])
def test_what_cannot_be_understood_names_none(tmp_path, content):
    (tmp_path / "a.gltf").write_text(content)
    assert side_files(tmp_path / "a.gltf") == []


def test_another_texture_is_another_building(obj):
    before = mesh_digest(obj)
    (obj.parent / "wall.png").write_bytes(b"another")
    assert mesh_digest(obj) != before


def test_a_file_without_others_has_its_own_digest(tmp_path):
    (tmp_path / "a.ply").write_text("ply")
    assert mesh_digest(tmp_path / "a.ply") == file_hash(tmp_path / "a.ply")
