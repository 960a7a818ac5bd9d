"""Small buildings whose every measure is known."""

import json
import struct

import numpy as np

from avs.slam.building.building_mesh import Building

FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def quad(a, b, c, d):
    """Return the corners of a rectangle, in order around it."""
    return np.array([a, b, c, d], np.float32)


def box_faces(low, high):
    """Return the six rectangles of a box: floor, ceiling, then the walls at x low, x high, y low, y high."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    return [
        quad((x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)),
        quad((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),
        quad((x0, y0, z0), (x0, y1, z0), (x0, y1, z1), (x0, y0, z1)),
        quad((x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)),
        quad((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)),
        quad((x0, y1, z0), (x1, y1, z0), (x1, y1, z1), (x0, y1, z1)),
    ]


def building(rectangles, colors=None):
    """Return the rectangles as a mesh, each of one colour."""
    count = len(rectangles)
    vertices = np.concatenate(rectangles).astype(np.float32)
    triangles = np.concatenate([FACES + 4 * k for k in range(count)]).astype(np.int32)
    shades = np.full((count, 3), 0.5, np.float32) if colors is None else np.asarray(colors, np.float32)
    return Building(
        vertices,
        triangles,
        np.repeat(shades, 4, axis=0),
        np.zeros((len(triangles), 3, 2), np.float32),
        np.full(len(triangles), -1, np.int32),
        (),
    )


def room(width=4.0, length=3.0, height=2.5, things=()):
    """Return a closed room from the origin on, with boxes ``(low, high)`` standing in it; each face has its colour."""
    faces = box_faces((0, 0, 0), (width, length, height))
    for low, high in things:
        faces += box_faces(low, high)
    rng = np.random.default_rng(0)
    return building(faces, rng.uniform(0.2, 0.9, (len(faces), 3)))


def textured(mesh):
    """Return a mesh of rectangles with a blurred pattern by chance on each, so that every place looks different."""
    rng = np.random.default_rng(1)
    faces = len(mesh.triangles) // 2
    corners = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], np.float32)
    pictures = tuple(rng.integers(30, 226, (12, 12, 3)).astype(np.uint8) for _ in range(faces))
    return Building(
        mesh.vertices,
        mesh.triangles,
        np.ones_like(mesh.vertices),
        np.tile(corners, (faces, 1, 1)),
        np.repeat(np.arange(faces, dtype=np.int32), 2),
        pictures,
    )


def write_glb(path, positions, coordinates, triangles, picture=None, mime="image/png", **extra):
    """Write one textured mesh as a glTF file of one buffer."""
    chunks = [np.asarray(positions, "<f4").tobytes(), np.asarray(coordinates, "<f4").tobytes()]
    chunks += [np.asarray(triangles, "<u4").tobytes(), *([picture] if picture else [])]
    views, offset = [], 0
    for chunk in chunks:
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": len(chunk)})
        offset += -(-len(chunk) // 4) * 4
    data = b"".join(chunk + b"\0" * (-len(chunk) % 4) for chunk in chunks)
    positions = np.asarray(positions, float)
    bounds = {"min": positions.min(0).tolist(), "max": positions.max(0).tolist()}
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3", **bounds},
        {"bufferView": 1, "componentType": 5126, "count": len(positions), "type": "VEC2"},
        {"bufferView": 2, "componentType": 5125, "count": 3 * len(triangles), "type": "SCALAR"},
    ]
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}
    described = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
        **extra,
    }
    if picture:
        primitive["material"] = 0
        described["images"] = [{"bufferView": 3, "mimeType": mime}]
        described["textures"] = [{"source": 0}]
        described["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    header = json.dumps(described).encode()
    header += b" " * (-len(header) % 4)
    total = 12 + 8 + len(header) + 8 + len(data)
    path.write_bytes(
        b"glTF" + struct.pack("<II", 2, total)
        + struct.pack("<I", len(header)) + b"JSON" + header
        + struct.pack("<I", len(data)) + b"BIN\0" + data
    )  # fmt: skip
