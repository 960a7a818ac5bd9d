"""A flat as one mesh with its light and textures in the vertices' colours, for simulators that ray-cast a mesh."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.camera.film import tone
from avs.datasets.embedded.camera.lens import Lens
from avs.datasets.embedded.camera.render import meter
from avs.datasets.embedded.camera.trajectories import walkthrough
from avs.datasets.embedded.embedded_settings import EmbeddedSettings
from avs.datasets.embedded.geometry.mesh_model import Array, assemble
from avs.datasets.embedded.geometry.raycast import Hits
from avs.datasets.embedded.layouts.house import flat
from avs.datasets.embedded.layouts.indoor import room_light
from avs.datasets.embedded.layouts.stage import Stage
from avs.datasets.embedded.light.shading import Shader
from avs.system.files import atomic_folder, write_json

FINEST = 0.02
"""Edges are not halved below this length in metres."""

CONTRAST = 0.04
"""Edges are halved where the colour in their middle differs by more than this (of 1) from the mean of their ends."""

_CHUNK = 1 << 16

Colors = Callable[[npt.NDArray[np.int64], Array], Array]


def refine(
    triangles: npt.NDArray[np.int32], vertices: Array, colors: Colors
) -> tuple[npt.NDArray[np.int64], Array, Array]:
    """Halve triangles at their longest edge wherever the colours between their corners need it.

    Args:
        triangles: ``[t, 3]`` vertex indices.
        vertices: ``[v, 3]`` metres.
        colors: returns the colours ``[n, 3]`` in 0..1 at barycentric weights ``[n, 3]`` of triangles ``[n]``.

    Returns:
        source: ``[n]`` the triangle that each new triangle is a part of.
        weights: ``[n, 3, 3]`` the barycentric weights there of the new triangle's corners.
        shades: ``[n, 3, 3]`` the corners' colours.
    """
    source = np.arange(len(triangles))
    weights = np.tile(np.eye(3, dtype=np.float32), (len(triangles), 1, 1))
    shades = colors(np.repeat(source, 3), weights.reshape(-1, 3)).reshape(-1, 3, 3)
    done: list[tuple[npt.NDArray[np.int64], Array, Array]] = []
    while len(source):
        corners = weights @ vertices[triangles[source]]
        # Edge k lies opposite to corner k.
        edges = np.linalg.norm(np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1), axis=2)
        order = ((edges.argmax(axis=1)[:, None] + np.arange(3)) % 3)[:, :, None]
        weights, shades = np.take_along_axis(weights, order, axis=1), np.take_along_axis(shades, order, axis=1)
        middle, color = weights[:, 1:].mean(axis=1), np.zeros((len(source), 3), np.float32)
        split = np.zeros(len(source), bool)
        wide = np.flatnonzero(edges.max(axis=1) > FINEST)
        color[wide] = colors(source[wide], middle[wide])
        # The middle alone could by chance have the mean colour of its ends.
        for inner in (np.array([0.0, 0.5, 0.5]), np.array([0.4, 0.42, 0.18]), np.array([0.2, 0.15, 0.65])):
            found = color[wide] if not inner[0] else colors(source[wide], inner.astype(np.float32) @ weights[wide])
            split[wide[np.abs(found - inner @ shades[wide]).max(axis=1) > CONTRAST]] = True
            wide = wide[~split[wide]]
        done.append((source[~split], weights[~split], shades[~split]))
        weights, shades = _halved(weights[split], middle[split]), _halved(shades[split], color[split])
        source = np.concatenate([source[split], source[split]])
    return tuple(np.concatenate(parts) for parts in zip(*done, strict=True))  # type: ignore[return-value]


def _halved(corners: Array, middle: Array) -> Array:
    """Return ``[2n, 3, 3]``: both halves of triangles that are cut from corner 0 to the ``middle`` of the other two."""
    apex, first, second = corners[:, 0], corners[:, 1], corners[:, 2]
    return np.concatenate([np.stack([apex, first, middle], 1), np.stack([apex, middle, second], 1)])


def colored_mesh(shader: Shader, exposure: float) -> tuple[Array, npt.NDArray[np.uint8], npt.NDArray[np.int64]]:
    """Return vertices ``[v, 3]``, their sRGB colours ``[v, 3]`` and triangles ``[t, 3]`` of the lit scene."""
    model = shader.model

    def colors(source: npt.NDArray[np.int64], weights: Array) -> Array:
        return tone(_light(shader, source, weights), exposure) * np.float32(1 / 255)

    source, weights, shades = refine(model.triangles, model.vertices, colors)
    corners = weights @ model.vertices[model.triangles[source]]
    # Corners at one place of one material share a vertex; a tenth of a millimetre tells places apart.
    key = np.concatenate([np.rint(corners * 1e4), np.repeat(_facing(shader, source)[:, None], 3, axis=1)], axis=2)
    packed = key.reshape(-1, 4).astype(np.int32).view("V16").ravel()
    _, first, faces = np.unique(packed, return_index=True, return_inverse=True)
    return (
        corners.reshape(-1, 3)[first],
        np.rint(shades.reshape(-1, 3)[first] * 255).astype(np.uint8),
        faces.reshape(-1, 3),
    )


def _light(shader: Shader, source: npt.NDArray[np.int64], weights: npt.NDArray[np.floating]) -> Array:
    """Return the radiance ``[n, 3]`` at barycentric ``weights`` of triangles, each seen from straight above."""
    model, above = shader.model, 0.05
    light = np.zeros((len(source), 3), np.float32)
    for start in range(0, len(source), _CHUNK):
        part = slice(start, start + _CHUNK)
        normal = shader.face_normals[source[part]]
        part_weights = weights[part].astype(np.float32)
        points = np.einsum("nk,nkc->nc", part_weights, model.vertices[model.triangles[source[part]]])
        hits = Hits(np.full(len(normal), above, np.float32), source[part], part_weights)
        # The middle of sun and lamps, and the level of detail that belongs to the finest edges.
        draws = np.tile(np.array([0.0, 0.0, 0.5], np.float32), (len(normal), 1))
        light[part] = shader.shade(points + above * normal, -normal, hits, FINEST / above, draws)
    return light


def _facing(shader: Shader, source: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return ``[n, 1]``: one number for the material and the rough direction of each triangle."""
    octant = (shader.face_normals[source] > 0) @ np.array([1, 2, 4])
    axis = np.abs(shader.face_normals[source]).argmax(axis=1)
    return np.asarray((shader.model.triangle_material[source] * 8 + octant) * 3 + axis, np.int64)[:, None]


def write_apartment(seed: int, folder: Path, settings: EmbeddedSettings) -> None:
    """Write a flat to ``folder``.

    ``mesh.ply`` is in metres, z upwards, with coloured vertices; ``apartment.json`` has the rooms and a walk.
    """
    rng = np.random.default_rng([seed, 5, 0])
    home = flat(2, int(rng.integers(2, 4)), rng)
    # The garden outside is left away: a simulator's map ends at the windows.
    meshes = tuple(mesh for part in home.meshes[1:] for mesh in part)
    light = room_light(list(home.rooms), home.lamps, rng)
    stage = Stage(meshes, light, (*home.rooms[0].center, 1.2), 1.5, path=home.path)
    shader = Shader(assemble(meshes), light, settings, seed)
    cameras = Lens(1.5, 80).cameras(walkthrough(stage, 24, shader.caster, rng), 32)
    vertices, colors, faces = colored_mesh(shader, meter(shader, cameras, rng))
    rooms = [{"use": r.use, "x": [r.x0, r.x1], "y": [r.y0, r.y1], "height": r.height} for r in home.rooms]
    with atomic_folder(folder) as temporary:
        (temporary / "mesh.ply").write_bytes(ply_bytes(vertices, faces, colors))
        write_json(temporary / "apartment.json", {"seed": seed, "rooms": rooms, "walk": [list(p) for p in home.path]})


def ply_bytes(
    vertices: Array, triangles: npt.NDArray[np.integer], colors: npt.NDArray[np.uint8] | None = None
) -> bytes:
    """Return a binary PLY file of a triangle mesh, with vertex colours if given."""
    fields: list[tuple[str, str]] = [(axis, "<f4") for axis in "xyz"]
    names = {"<f4": "float", "u1": "uchar"}
    if colors is not None:
        fields += [(name, "u1") for name in ("red", "green", "blue")]
    table = np.zeros(len(vertices), fields)
    for k, (name, _) in enumerate(fields):
        table[name] = vertices[:, k] if k < 3 else colors[:, k - 3]  # type: ignore[index]
    faces = np.zeros(len(triangles), [("count", "u1"), ("index", "<i4", 3)])
    faces["count"], faces["index"] = 3, triangles
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property {names[kind]} {name}" for name, kind in fields]
    header += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(header).encode() + table.tobytes() + faces.tobytes()
