"""A look at the meshes of buildings before a run: each fault is one line with the name of the file."""

import json
import os

import pytest
from building_factory import write_glb

from avs.slam.building.usable_mesh import check_building
from avs.system.errors import UserError


@pytest.fixture
def wall(tmp_path):
    corners = [(2, 0, 1), (2, 0, -2), (2, 2.5, -2), (2, 2.5, 1)]
    write_glb(tmp_path / "wall.glb", corners, [(1, 1), (0, 1), (0, 0), (1, 0)], [[0, 1, 2], [0, 2, 3]])
    return tmp_path / "wall.glb"


def test_a_whole_mesh_passes(wall):
    check_building(wall)


@pytest.mark.parametrize(
    ("name", "content", "fault"),
    [
        ("none.ply", None, "is no file"),
        ("folder.ply/inside", b"", "folder.ply: is no file"),
        ("mesh.stl", b"solid", "is no mesh that is read"),
        ("empty.obj", b"", "is empty"),
        ("text.glb", b"hello", "its first bytes are not glTF"),
        ("list.gltf", b"[]", "is no readable glTF file"),
        ("br{ace}.ply", b"ply", "has a name that the workflow cannot take"),
    ],
)
def test_what_cannot_be_read_is_told(tmp_path, name, content, fault):
    path = tmp_path / name
    if content is not None:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)
    with pytest.raises(UserError, match=fault) as caught:
        check_building(path.parent if path.name == "inside" else path)
    assert "\n" not in str(caught.value)


def test_half_a_download_is_told(wall):
    content = wall.read_bytes()
    wall.write_bytes(content[:-10])
    with pytest.raises(UserError, match=f"has {len(content) - 10} of {len(content)} bytes"):
        check_building(wall)


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may open any file")
def test_a_file_without_permission_is_told(wall):
    wall.chmod(0)
    with pytest.raises(UserError, match=r"wall.glb: permission denied"):
        check_building(wall)


def test_side_files_are_looked_at_too(tmp_path):
    told = {"images": [{"uri": "a{b}.png"}], "asset": {"version": "2.0"}}
    (tmp_path / "a.gltf").write_text(json.dumps(told))
    check_building(tmp_path / "a.gltf")  # not there: readers do without it
    (tmp_path / "a{b}.png").write_bytes(b"x")
    with pytest.raises(UserError, match="name that the workflow cannot take"):
        check_building(tmp_path / "a.gltf")
    (tmp_path / "b.gltf").write_text(json.dumps({"images": [{"uri": "n" * 300}]}))
    with pytest.raises(UserError, match="file name too long"):
        check_building(tmp_path / "b.gltf")
