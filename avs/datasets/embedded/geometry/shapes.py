"""Primitive meshes, with texture coordinates in metres, outward normals and vertices close enough to store light at.

``cell`` is everywhere the greatest wanted distance between neighbouring vertices, in metres.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.geometry.mesh_model import Array, Material, Mesh, unit

Floats = npt.NDArray[np.floating]

GRAINED = ("wood", "planks", "metal")
"""Textures whose grain runs along their first coordinate."""


def _grid_triangles(rows: int, columns: int) -> npt.NDArray[np.int32]:
    """Return the triangles of a grid of rows x columns vertices, numbered row by row."""
    index = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    a, b, c, d = (index[:-1, :-1].ravel(), index[:-1, 1:].ravel(), index[1:, 1:].ravel(), index[1:, :-1].ravel())
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def _steps(length: float, cell: float) -> int:
    return max(1, int(np.ceil(length / cell)))


def surface(points: Floats, coordinates: Floats, material: Material, normals: Floats | None = None) -> Mesh:
    """Return the mesh of a grid of points ``[rows, columns, 3]`` with texture coordinates ``[rows, columns, 2]``.

    The normal is the columns' direction x the rows' direction.
    Without ``normals`` they come from the grid's differences.
    """
    rows, columns = points.shape[:2]
    if normals is None:
        normals = np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0))
    return Mesh(
        points.reshape(-1, 3).astype(np.float32),
        unit(np.asarray(normals).reshape(-1, 3)),
        coordinates.reshape(-1, 2).astype(np.float32),
        _grid_triangles(rows, columns),
        material,
    )


def quad(
    corner: Sequence[float],
    right: Sequence[float],
    up: Sequence[float],
    material: Material,
    cell: float = 0.25,
    picture: bool = False,
) -> Mesh:
    """Return a parallelogram; its front is where ``right`` x ``up`` points.

    Args:
        corner: lower left corner.
        right: lower edge.
        up: left edge.
        material: of the surface.
        cell: greatest distance of vertices.
        picture: show the texture once, upright, instead of repeating it by the metre.
    """
    corner_, right_, up_ = (np.asarray(v, np.float64) for v in (corner, right, up))
    width, height = float(np.linalg.norm(right_)), float(np.linalg.norm(up_))
    s, t = np.linspace(0, 1, _steps(width, cell) + 1), np.linspace(0, 1, _steps(height, cell) + 1)
    points = corner_ + s[None, :, None] * right_ + t[:, None, None] * up_
    # Rows of a texture run downwards. Pictures keep clear of the border, which would repeat the opposite one.
    once = material.size
    u, v = (once * (0.005 + 0.99 * s), once * (0.995 - 0.99 * t)) if picture else (s * width, -t * height)
    coordinates = np.stack(np.broadcast_arrays(u[None, :], v[:, None]), -1)
    normal = np.broadcast_to(np.cross(right_, up_), points.shape)
    return surface(points, coordinates, material, normal)


def box(size: Sequence[float], material: Material, cell: float = 0.25, bevel: float = 0.01) -> Mesh:
    """Return a box with rounded edges, centred in x and y, standing on z = 0.

    Args:
        size: extent along x, y and z.
        material: of all sides.
        cell: greatest distance of vertices.
        bevel: radius of the edges; 0 for sharp ones.
    """
    half = np.asarray(size, np.float64) / 2
    radius = min(bevel, float(half.min()) * 0.99)
    parts = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            parts.append(_box_side(half, radius, cell, axis, sign, material.texture in GRAINED))
    starts = np.cumsum([0] + [len(part[0]) for part in parts])
    vertices = np.concatenate([part[0] for part in parts]) + np.array([0, 0, half[2]])
    return Mesh(
        vertices.astype(np.float32),
        unit(np.concatenate([part[1] for part in parts])),
        np.concatenate([part[2] for part in parts]).astype(np.float32),
        np.concatenate([part[3] + start for part, start in zip(parts, starts, strict=False)]).astype(np.int32),
        material,
    )


def _box_side(
    half: Floats, radius: float, cell: float, axis: int, sign: float, along_grain: bool
) -> tuple[Floats, Floats, Floats, npt.NDArray[np.int32]]:
    # The two axes along the side, ordered so that their cross product points outwards.
    first, second = ((axis + 1) % 3, (axis + 2) % 3) if sign > 0 else ((axis + 2) % 3, (axis + 1) % 3)
    lines = []
    for along in (first, second):
        inner = half[along] - radius
        if not radius:
            lines.append(np.linspace(-inner, inner, _steps(2 * inner, cell) + 1))
            continue
        middle = np.linspace(-inner, inner, _steps(2 * inner, cell) + 1)
        # A small bevel needs no point in its middle.
        bend = [half[along] - 0.3 * radius, half[along]] if radius > 0.005 else [half[along]]
        lines.append(np.concatenate([-np.array(bend[::-1]), middle, bend]))
    points = np.zeros((len(lines[1]), len(lines[0]), 3))
    points[..., first], points[..., second] = lines[0][None, :], lines[1][:, None]
    points[..., axis] = sign * half[axis]
    core = np.clip(points, radius - half, half - radius)
    normals = points - core
    if not radius:
        normals[..., axis] = sign
    rounded = core + radius * normals / np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    # Texture: horizontal direction along u, vertical (z) along -v, so that bricks and books stand upright; but grain
    # runs along the longest edge.
    u, v = (first, second) if second == 2 or axis == 2 else (second, first)
    if along_grain and half[v] > half[u]:
        u, v = v, u
    coordinates = np.stack([points[..., u], -points[..., v]], -1)
    return (
        rounded.reshape(-1, 3),
        normals.reshape(-1, 3),
        coordinates.reshape(-1, 2),
        _grid_triangles(*points.shape[:2]),
    )


def lathe(
    profile: Sequence[tuple[float, float]],
    material: Material,
    cell: float = 0.1,
    segments: int = 0,
    picture: bool = False,
) -> Mesh:
    """Return the surface of revolution of ``profile`` about the z axis.

    Args:
        profile: (radius, height) pairs in order; the outside lies to the right of the direction of travel upwards.
            Sharp corners come from a point given twice.
        material: of the surface.
        cell: greatest distance of vertices along the profile.
        segments: around the axis; 0 chooses by the greatest radius.
        picture: wrap the texture once around, instead of repeating it by the metre.
    """
    line = _dense(np.asarray(profile, np.float64), cell)
    radius = float(line[:, 0].max())
    around = segments or int(np.clip(2 * np.pi * radius / min(cell, 0.35 * radius + 1e-3), 14, 64))
    angle = np.linspace(0, 2 * np.pi, around + 1)
    normal = _profile_normals(line)
    points = np.stack(np.broadcast_arrays(line[:, :1] * np.cos(angle), line[:, :1] * np.sin(angle), line[:, 1:]), -1)
    normals = np.stack(
        np.broadcast_arrays(normal[:, :1] * np.cos(angle), normal[:, :1] * np.sin(angle), normal[:, 1:]), -1
    )
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    once = material.size
    u, v = (
        (once * angle / (2 * np.pi), once * (1 - length / max(length[-1], 1e-9)))
        if picture
        else (angle * radius, -length)
    )
    coordinates = np.stack(np.broadcast_arrays(u[None, :], v[:, None]), -1)
    if material.texture in GRAINED and not picture:
        coordinates = coordinates[..., ::-1]
    return surface(points, coordinates, material, normals)


def _dense(nodes: Floats, cell: float) -> Floats:
    """Return the polyline ``nodes`` ``[n, 2]`` with points between them, none farther apart than ``cell``."""
    pieces = [nodes[:1]]
    for a, b in itertools.pairwise(nodes):
        count = _steps(float(np.linalg.norm(b - a)), cell)
        pieces.append(a + (b - a) * (np.arange(1, count + 1) / count)[:, None])
    return np.concatenate(pieces)


def _profile_normals(line: Floats) -> Floats:
    """Return the normals of a profile; at a repeated point each copy keeps the normal of its own side."""
    step = np.diff(line, axis=0)
    length = np.linalg.norm(step, axis=1)
    edge = np.stack([step[:, 1], -step[:, 0]], 1) / np.maximum(length, 1e-12)[:, None]
    before, after = np.vstack([edge[:1], edge]), np.vstack([edge, edge[-1:]])
    sharp_before = np.concatenate([[False], length < 1e-9])
    sharp_after = np.concatenate([length < 1e-9, [False]])
    total = np.where(sharp_before[:, None], 0, before) + np.where(sharp_after[:, None], 0, after)
    return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12))


def cylinder(radius: float, height: float, material: Material, cell: float = 0.1) -> Mesh:
    """Return a closed cylinder standing on z = 0."""
    edge = min(0.15 * radius, 0.01)
    return lathe(
        [
            (0, 0),
            (radius, 0),
            (radius, 0),
            (radius, height - edge),
            (radius - edge, height),
            (radius - edge, height),
            (0, height),
        ],
        material,
        cell,
    )


def ball(radius: float, material: Material, cell: float = 0.05, squash: float = 1.0) -> Mesh:
    """Return a ball that stands on z = 0; ``squash`` scales its height."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, max(8, _steps(np.pi * radius, cell)))
    profile = np.stack([radius * np.cos(angle), radius * squash * (1 + np.sin(angle))], 1)
    return lathe([(float(r), float(z)) for r, z in profile], material, cell)


def displaced(mesh: Mesh, offset: Callable[[Array], Floats]) -> Mesh:
    """Return ``mesh`` with each vertex moved along its normal by ``offset(vertices)``, and new normals.

    Vertices at the same place move together, also across the seam of a texture.
    """
    key = np.unique(np.round(mesh.vertices, 5), axis=0, return_inverse=True)[1].ravel()
    normal = np.zeros((key.max() + 1, 3))
    np.add.at(normal, key, mesh.normals)
    vertices = (mesh.vertices + unit(normal)[key] * np.asarray(offset(mesh.vertices))[:, None]).astype(np.float32)
    return with_smooth_normals(
        Mesh(vertices, mesh.normals, mesh.coordinates, mesh.triangles, mesh.material, mesh.shade, mesh.site), key
    )


def with_smooth_normals(mesh: Mesh, key: npt.NDArray[np.integer] | None = None) -> Mesh:
    """Return ``mesh`` with the area-weighted mean of its triangles' normals at each vertex; equal ``key`` share one."""
    key = np.arange(len(mesh.vertices)) if key is None else key
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    face = np.cross(b - a, c - a)
    total = np.zeros((int(key.max()) + 1, 3))
    for corner in range(3):
        np.add.at(total, key[mesh.triangles[:, corner]], face)
    return Mesh(mesh.vertices, unit(total)[key], mesh.coordinates, mesh.triangles, mesh.material, mesh.shade, mesh.site)


def tube(path: Floats, radii: Sequence[float] | Floats, material: Material, sides: int = 8) -> Mesh:
    """Return a tube around the polyline ``path`` ``[n, 3]`` with a radius at each node, open at the ends."""
    path = np.asarray(path, np.float64)
    direction = unit(np.gradient(path, axis=0)).astype(np.float64)
    helper = np.array([0.0, 0.0, 1.0]) if abs(direction[:, 2]).mean() < 0.8 else np.array([1.0, 0.0, 0.0])
    first = unit(np.cross(direction, helper)).astype(np.float64)
    second = np.cross(direction, first)
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    normals = first[:, None] * np.cos(angle)[:, None] + second[:, None] * np.sin(angle)[:, None]
    points = path[:, None] + normals * np.asarray(radii, np.float64)[:, None, None]
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    coordinates = np.stack(np.broadcast_arrays(angle[None, :] * float(np.mean(radii)), length[:, None]), -1)
    return surface(points, coordinates, material, normals)


def ground(radii: Floats, height: Callable[[Floats], Floats], material: Material, sectors: int = 96) -> Mesh:
    """Return terrain on rings of the given ``radii`` about the origin; ``height`` maps ``[n, 2]`` to metres."""
    angle = np.linspace(0, 2 * np.pi, sectors + 1)
    plane = np.stack(np.broadcast_arrays(radii[:, None] * np.cos(angle), radii[:, None] * np.sin(angle)), -1)
    z = np.asarray(height(plane.reshape(-1, 2))).reshape(plane.shape[:2])
    # Rings run outwards and sectors counterclockwise: sectors x rings would point down.
    points = np.concatenate([plane, z[..., None]], -1)[:, ::-1]
    return surface(points, plane[:, ::-1], material)
