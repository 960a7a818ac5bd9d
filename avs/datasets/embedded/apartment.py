"""A flat as one mesh with its light and textures in the vertices' colours, for simulators that ray-cast a mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.film import exposure_of, tone
from avs.datasets.embedded.house import flat
from avs.datasets.embedded.indoor import room_light
from avs.datasets.embedded.model import Array, assemble
from avs.datasets.embedded.raycast import Hits
from avs.datasets.embedded.settings import EmbeddedSettings
from avs.datasets.embedded.shading import Shader
from avs.files import atomic_folder, write_json

SPACING = 0.03
"""Greatest distance of neighbouring vertices in metres: as fine as the colours get."""


def refine(
    triangles: npt.NDArray[np.int32], vertices: Array, spacing: float
) -> tuple[npt.NDArray[np.int64], Array, npt.NDArray[np.int64]]:
    """Cut triangles evenly until no edge is longer than ``spacing``.

    Args:
        triangles: ``[t, 3]`` vertex indices.
        vertices: ``[v, 3]`` metres.
        spacing: metres.

    Returns:
        source: ``[n]`` the triangle that each new vertex lies in.
        weights: ``[n, 3]`` its barycentric weights there.
        faces: ``[m, 3]`` the new triangles.
    """
    corners = vertices[triangles]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = np.maximum(np.ceil(longest / spacing), 1).astype(np.int64)
    sources, weights, faces, count = [], [], [], 0
    for number in np.unique(parts):
        rows = np.flatnonzero(parts == number)
        grid, pattern = _pattern(int(number))
        sources.append(np.repeat(rows, len(grid)))
        weights.append(np.tile(grid, (len(rows), 1)))
        start = count + len(grid) * np.arange(len(rows))[:, None, None]
        faces.append((pattern[None] + start).reshape(-1, 3))
        count += len(grid) * len(rows)
    return np.concatenate(sources), np.concatenate(weights).astype(np.float32), np.concatenate(faces)


def _pattern(number: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Return the barycentric grid of a triangle whose edges are cut into ``number`` parts, and its triangles."""
    nodes = [(i, j) for i in range(number + 1) for j in range(number + 1 - i)]
    index = {node: k for k, node in enumerate(nodes)}
    faces = []
    for i, j in nodes:
        if i + j < number:
            faces.append((index[i, j], index[i + 1, j], index[i, j + 1]))
        if i + j < number - 1:
            faces.append((index[i + 1, j], index[i + 1, j + 1], index[i, j + 1]))
    first, second = np.array(nodes, np.float64).T / number
    return np.stack([1 - first - second, first, second], axis=1), np.array(faces, np.int64)


def colored_mesh(
    shader: Shader, spacing: float = SPACING
) -> tuple[Array, npt.NDArray[np.uint8], npt.NDArray[np.int64]]:
    """Return vertices ``[v, 3]``, their sRGB colours ``[v, 3]`` and triangles ``[t, 3]`` of the lit scene."""
    model = shader.model
    source, weights, faces = refine(model.triangles, model.vertices, spacing)
    corners = model.triangles[source]
    vertices = np.einsum("nk,nkc->nc", weights, model.vertices[corners])
    colors = np.zeros_like(vertices)
    above = 0.05
    rng = np.random.default_rng(0)
    for start in range(0, len(vertices), 1 << 18):
        part = slice(start, start + (1 << 18))
        normal = shader.face_normals[source[part]]
        hits = Hits(np.full(len(normal), above, np.float32), source[part], weights[part])
        draws = rng.random((len(normal), 3), dtype=np.float32)
        # Each vertex is seen from straight above, by a ray as wide as the spacing.
        colors[part] = shader.shade(vertices[part] + above * normal, -normal, hits, spacing / above, draws)
    return vertices, tone(colors, exposure_of(colors)), faces


def write_apartment(seed: int, folder: Path, settings: EmbeddedSettings) -> None:
    """Write ``mesh.ply`` (metres, z upwards, coloured vertices) and ``apartment.json`` (rooms and a walk) to ``folder``."""
    rng = np.random.default_rng([seed, 5, 0])
    home = flat(2, int(rng.integers(2, 4)), rng)
    # The garden outside is left away: a simulator's map ends at the windows.
    model = assemble(mesh for part in home.meshes[1:] for mesh in part)
    shader = Shader(model, room_light(list(home.rooms), home.lamps, rng), settings, seed)
    vertices, colors, faces = colored_mesh(shader)
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
