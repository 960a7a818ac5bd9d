"""Textures that a mesh names and that are missing or cut: another building, if nothing is said."""

import base64
import io
import json
import struct

import numpy as np
import pytest
from PIL import Image

from avs.slam.building.building_files import read_building
from avs.slam.building.usable_mesh import check_building
from avs.system.errors import UserError

FACES = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl one\nf 1/1 2/2 3/3\n"
MATERIALS = "newmtl one\nKd 1 1 1\nmap_Kd wall.png\nmap_Bump gone.png\nnewmtl two\nmap_Kd of_no_face.png\n"


def picture(kind="PNG"):
    pixels = np.random.default_rng(0).integers(0, 255, (64, 64, 3), dtype=np.uint8)
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, kind)
    return stream.getvalue()


@pytest.fixture
def obj(tmp_path):
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{FACES}")
    (tmp_path / "a.mtl").write_text(MATERIALS)
    (tmp_path / "wall.png").write_bytes(picture())
    return tmp_path / "a.obj"


def test_a_mesh_with_all_that_faces_use_passes(obj):
    check_building(obj)
    assert len(read_building(obj).textures) == 1


def test_a_texture_that_is_not_there_is_told(obj):
    (obj.parent / "wall.png").unlink()
    for look in (check_building, read_building):
        with pytest.raises(UserError, match=r"a.obj: the texture wall.png of its material one is not there"):
            look(obj)


def test_a_file_of_materials_that_is_not_there_is_told(obj):
    (obj.parent / "a.mtl").unlink()
    with pytest.raises(UserError, match=r"a.obj: the file of materials that it names, a.mtl, is not there"):
        check_building(obj)


def test_a_mesh_that_names_no_materials_needs_none(obj):
    obj.write_text(FACES)
    (obj.parent / "a.mtl").unlink()
    check_building(obj)


@pytest.mark.parametrize("kind", ["PNG", "JPEG"])
def test_half_a_texture_is_told(obj, kind):
    whole = picture(kind)
    (obj.parent / "wall.png").write_bytes(whole)
    check_building(obj)
    (obj.parent / "wall.png").write_bytes(whole[: len(whole) // 2])
    for look in (check_building, read_building):
        with pytest.raises(UserError, match=r"a.obj: its texture wall.png is damaged or cut off") as caught:
            look(obj)
        assert "\n" not in str(caught.value)


def test_damage_amid_a_texture_is_told_as_it_is_read(obj):
    whole = bytearray(picture())
    whole[len(whole) // 2] ^= 255
    (obj.parent / "wall.png").write_bytes(whole)
    check_building(obj)
    with pytest.raises(UserError, match=r"a.obj: its texture wall.png is damaged"):
        read_building(obj)


def gltf(folder, image, binary=None):
    """Write a textured triangle, its numbers in a buffer of its own; ``image`` is the entry of its texture."""
    numbers = (
        np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
        + np.array([[0, 0], [1, 0], [0, 1]], "<f4").tobytes()
    )
    content = numbers + (binary or b"")
    views = [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}]
    views += [{"buffer": 0, "byteOffset": 60, "byteLength": len(binary)}] if binary else []
    described = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "scene": 0,
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "normalTexture": {"index": 1}},
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}},
        ],
        "textures": [{"source": 0}, {"source": 1}],
        "images": [image, {"uri": "never_there.png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": len(content)}],
    }
    if binary is None:
        described["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
        (folder / "a.gltf").write_text(json.dumps(described))
        return folder / "a.gltf"
    head = json.dumps(described).encode()
    head += b" " * (-len(head) % 4)
    content += b"\0" * (-len(content) % 4)
    total = 12 + 8 + len(head) + 8 + len(content)
    (folder / "a.glb").write_bytes(
        struct.pack("<4sII", b"glTF", 2, total)
        + struct.pack("<I4s", len(head), b"JSON")
        + head
        + struct.pack("<I4s", len(content), b"BIN\0")
        + content
    )
    return folder / "a.glb"


def test_a_texture_beside_a_gltf_file_must_be_there_and_whole(tmp_path):
    path = gltf(tmp_path, {"uri": "wall.png"})
    with pytest.raises(UserError, match=r"a.gltf: the texture wall.png is not there"):
        check_building(path)
    (tmp_path / "wall.png").write_bytes(picture()[:-2000])
    with pytest.raises(UserError, match=r"its texture wall.png is damaged"):
        check_building(path)
    (tmp_path / "wall.png").write_bytes(picture())
    check_building(path)
    assert len(read_building(path).textures) == 1


def test_a_texture_that_open3d_does_not_find_is_told(tmp_path):
    path = gltf(tmp_path, {"uri": "wall%20paper.png"})
    (tmp_path / "wall paper.png").write_bytes(picture())
    check_building(path)
    with pytest.raises(UserError, match=r"a.gltf: names textures that Open3D does not find or cannot read"):
        read_building(path)


@pytest.mark.parametrize("embedded", ["data", "chunk"])
def test_a_texture_in_a_gltf_file_must_be_whole(tmp_path, embedded):
    def write(content):
        if embedded == "chunk":
            return gltf(tmp_path, {"bufferView": 2, "mimeType": "image/png", "name": "wall"}, content)
        uri = "data:image/png;base64," + base64.b64encode(content).decode()
        return gltf(tmp_path, {"uri": uri, "name": "wall"})

    assert len(read_building(write(picture())).textures) == 1
    with pytest.raises(UserError, match=r"its texture wall is damaged or cut off"):
        read_building(write(picture()[:-2000]))


def test_a_texture_is_multiplied_with_the_colour_of_its_material(tmp_path):
    path = gltf(tmp_path, {"uri": "wall.png"})
    Image.fromarray(np.full((4, 4, 3), 188, np.uint8)).save(tmp_path / "wall.png")
    plain = read_building(path).textures[0]
    assert (plain == 188).all()
    described = json.loads(path.read_text())
    described["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = [1.0, 0.5, 0.0, 1.0]
    path.write_text(json.dumps(described))
    # 188 is half the light of 255: half of that is a quarter, which sRGB encodes as 137
    assert np.unique(read_building(path).textures[0].reshape(-1, 3), axis=0).tolist() == [[188, 137, 0]]
