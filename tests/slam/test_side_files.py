"""Files that a mesh names are part of what an exploration was made of."""

import json

import pytest

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
