"""Houses seen from outside, garden walls, and walls with openings."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from avs.datasets.embedded.geometry.mesh_model import Group, Material, Mesh, moved, unit
from avs.datasets.embedded.geometry.shapes import box, quad, tube
from avs.datasets.embedded.materials.palette import blossom, color, paint
from avs.datasets.embedded.things.plants import bouquet

Generator = np.random.Generator
Opening = tuple[float, float, float, float]
"""Left, bottom, width, height of a hole in a wall, metres from its lower left corner."""

PANE = Material("marble", 2.0, (0.06, 0.07, 0.08), 0.06, 0.08)


def wall(
    width: float,
    height: float,
    thickness: float,
    openings: Sequence[Opening],
    front: Material,
    back: Material,
    cell: float = 0.3,
    backed: bool = True,
) -> Group:
    """Return a wall along x from the origin: its front faces -y at y = 0, its back (if any) +y at ``thickness``."""
    xs = sorted({0.0, width, *(x for o in openings for x in (o[0], o[0] + o[2]))})
    zs = sorted({0.0, height, *(z for o in openings for z in (o[1], o[1] + o[3]))})
    group: Group = []
    for x0, x1 in itertools.pairwise(xs):
        for z0, z1 in itertools.pairwise(zs):
            x, z = (x0 + x1) / 2, (z0 + z1) / 2
            if any(o[0] < x < o[0] + o[2] and o[1] < z < o[1] + o[3] for o in openings):
                continue
            for y, material, flip in ((0.0, front, False), (thickness, back, True))[: 1 + backed]:
                corner, right = ((x1, y, z0), (x0 - x1, 0, 0)) if flip else ((x0, y, z0), (x1 - x0, 0, 0))
                piece = quad(corner, right, (0, 0, z1 - z0), material, cell)
                points = piece.vertices
                # One texture over the whole wall, however it is cut.
                coordinates = np.stack([-points[:, 0] if flip else points[:, 0], -points[:, 2]], 1)
                group.append(
                    type(piece)(points, piece.normals, coordinates.astype(np.float32), piece.triangles, material)
                )
    for left, bottom, w, h in openings:
        group += [
            quad((left, 0, bottom), (0, thickness, 0), (0, 0, h), back, cell),
            quad((left + w, thickness, bottom), (0, -thickness, 0), (0, 0, h), back, cell),
            quad((left, thickness, bottom + h), (w, 0, 0), (0, -thickness, 0), back, cell),
        ]
        group.append(quad((left, 0, bottom), (w, 0, 0), (0, thickness, 0), back, cell))
    return group


def casement(opening: Opening, thickness: float, frame: Material, glazed: bool, cell: float = 0.3) -> Group:
    """Return the frame, bars and sill of a window in ``opening``, and panes if ``glazed``."""
    left, bottom, w, h = opening
    t, y = 0.06, thickness * 0.45
    group: Group = [
        box((w + 0.16, thickness * 0.5 + 0.08, 0.05), frame, cell, 0.008).moved(
            left + w / 2, thickness * 0.25 - 0.05, bottom - 0.05
        )
    ]
    for x in (t / 2, w / 2, w - t / 2):
        group.append(box((t, 0.06, h), frame, cell, 0.006).moved(left + x, y, bottom))
    for z in (0.0, 0.55 * h, h - t):
        group.append(box((w, 0.055, t), frame, cell, 0.006).moved(left + w / 2, y, bottom + z))
    if glazed:
        group.append(quad((left, y, bottom), (w, 0, 0), (0, 0, h), PANE, 1.0))
    return group


def door(opening: Opening, thickness: float, rng: Generator) -> Group:
    """Return a closed panelled door with its frame and step."""
    left, bottom, w, h = opening
    paint = Material("wood", 0.8, color(rng, 0.15, 0.7), 0.4)
    group: Group = [box((w, 0.05, h), paint, 0.2, 0.004).moved(left + w / 2, thickness * 0.5, bottom)]
    for column in (0.27, 0.73):
        for low, rise in ((0.06, 0.36), (0.5, 0.42)):
            group.append(
                box((w * 0.34, 0.02, h * rise), paint, 0.2, 0.008).moved(
                    left + w * column, thickness * 0.5 - 0.03, bottom + h * low
                )
            )
    group.append(
        box((0.03, 0.06, 0.12), Material("metal", 0.3, (1.2, 1.0, 0.5), 0.3, 0.6), 0.1, 0.01).moved(
            left + w * 0.93, thickness * 0.5 - 0.05, bottom + h * 0.47
        )
    )
    group.append(
        box((w + 0.4, 0.5, 0.14), Material("stone", 1.0, roughness=0.8, relief=0.005), 0.15, 0.02).moved(
            left + w / 2, -0.15, bottom - 0.13
        )
    )
    return group


def house(rng: Generator) -> Group:
    """Return a house with its front at y = 0 facing -y, centred in x."""
    width, depth, eaves = rng.uniform(7, 10), 6.0, rng.uniform(3.0, 5.4)
    name = ("bricks", "plaster", "rubble")[int(rng.integers(3))]
    tint = paint(rng) if name == "plaster" else (1.0, 1.0, 1.0)
    face = Material(name, {"bricks": 1.05, "plaster": 3.0, "rubble": 1.8}[name], tint, 0.85, relief=0.01)
    frame = Material("wood", 0.8, color(rng, 0.7, 1.6), 0.5)
    shutters = color(rng, 0.25, 0.6)
    door_at: Opening = (width * rng.uniform(0.4, 0.5), 0.1, 1.0, 2.1)
    windows: list[Opening] = [(width * 0.12, 0.9, 1.1, 1.25), (width * 0.72, 0.9, 1.1, 1.25)]
    if eaves > 4.6:
        windows += [(width * x, 3.2, 1.0, 1.2) for x in (0.12, 0.44, 0.74)]
    group = wall(width, eaves, 0.3, [door_at, *windows], face, face, 0.5)
    group += door(door_at, 0.3, rng)
    for opening in windows:
        group += casement(opening, 0.3, frame, True)
        group += _shutters(opening, shutters)
        if rng.random() < 0.6:
            group += _flower_box(opening, rng)
    group += _gables(width, depth, eaves, face) + _trim(width, eaves, door_at, rng)
    return moved(group, -width / 2, 0, 0)


def _shutters(opening: Opening, paint: tuple[float, float, float]) -> Group:
    left, bottom, w, h = opening
    material = Material("planks", 0.7, tuple(2.2 * c for c in paint), 0.6, relief=0.006)  # type: ignore[arg-type]
    return [
        box((w * 0.45, 0.04, h), material, 0.3, 0.006).moved(x, -0.03, bottom)
        for x in (left - w * 0.25, left + w * 1.25)
    ]


def _flower_box(opening: Opening, rng: Generator) -> Group:
    left, bottom, w, _ = opening
    trough = box((w * 0.9, 0.2, 0.18), Material("planks", 0.6, (0.8, 0.7, 0.6), 0.7), 0.2, 0.01)
    group = moved([trough], left + w / 2, -0.18, bottom - 0.16)
    for x in np.linspace(0.15, 0.85, 4):
        group += moved(bouquet(0.16, 0.34, 8, rng, blossom(rng)), left + w * x, -0.18, bottom)
    return group


def _trim(width: float, eaves: float, door_at: Opening, rng: Generator) -> Group:
    """Return corner stones, the base, the gutter with its pipe, and a lantern beside the door."""
    tone = rng.uniform(0.7, 1.1)
    stone = Material("stone", 1.0, (tone, tone, tone * 0.95), 0.8, relief=0.004)
    zinc = Material("metal", 0.6, (0.6, 0.62, 0.65), 0.4, 0.4)
    group: Group = []
    for k, z in enumerate(np.arange(0.45, eaves - 0.25, 0.3)):
        for x, sign in ((0.0, 1), (width, -1)):
            size = 0.5 if k % 2 else 0.32
            group.append(
                box((size, 0.06, 0.28), stone, 0.3, 0.01).moved(x + sign * size / 2, -0.01, float(z)).shifted(rng)
            )
    for a, b in ((0.0, door_at[0] - 0.06), (door_at[0] + door_at[2] + 0.06, width)):
        group.append(box((b - a, 0.07, 0.45), stone, 0.3, 0.012).moved((a + b) / 2, -0.015, 0))
    line = np.array(
        [[-0.35, -0.41, eaves - 0.33], [width / 2, -0.41, eaves - 0.35], [width + 0.35, -0.41, eaves - 0.37]]
    )
    group.append(tube(line, np.full(3, 0.06), zinc, 8))
    pipe = np.array([[width - 0.6, -0.4, eaves - 0.36], [width - 0.6, -0.08, eaves - 0.75], [width - 0.6, -0.08, 0.05]])
    group.append(tube(pipe, np.full(3, 0.045), zinc, 8))
    x, z = door_at[0] - 0.35, 1.9
    iron = Material("metal", 0.3, (0.08, 0.08, 0.08), 0.4, 0.2)
    group.append(box((0.14, 0.14, 0.24), Material("marble", 0.3, (0.9, 0.85, 0.7), 0.15), 0.1, 0.02).moved(x, -0.16, z))
    group.append(box((0.19, 0.19, 0.03), iron, 0.2, 0.006).moved(x, -0.16, z + 0.24))
    group.append(box((0.03, 0.18, 0.03), iron, 0.2, 0.004).moved(x, -0.08, z + 0.26))
    return group


def _gables(width: float, depth: float, eaves: float, face: Material) -> Group:
    """Return the other walls of a house, its roof with eaves, and a chimney."""
    ridge, over = eaves + depth * 0.42, 0.35
    tiles = Material("roof_tiles", 2.4, roughness=0.8, relief=0.03)
    group: Group = [
        quad((0, depth, 0), (0, -depth, 0), (0, 0, eaves), face, 0.8),
        quad((width, 0, 0), (0, depth, 0), (0, 0, eaves), face, 0.8),
        quad((width, depth, 0), (-width, 0, 0), (0, 0, eaves), face, 0.8),
    ]
    for x, first, last in ((0.0, depth, 0.0), (width, 0.0, depth)):
        group.append(triangle((x, first, eaves), (x, last, eaves), (x, depth / 2, ridge), face))
    slope = (ridge - eaves) / (depth / 2)
    for y, direction in ((-over, 1.0), (depth + over, -1.0)):
        length = depth / 2 + over
        start = (-over, y, eaves - over * slope) if direction > 0 else (width + over, y, eaves - over * slope)
        right = ((width + 2 * over) * direction, 0.0, 0.0)
        group.append(quad(start, right, (0.0, direction * length, length * slope), tiles, 0.4))
        under = (start[0] + right[0], start[1], start[2] - 0.05)
        group.append(
            quad(
                under,
                (-right[0], 0.0, 0.0),
                (0.0, direction * length, length * slope),
                Material("planks", 1.0, roughness=0.8),
                0.6,
            )
        )
    group.append(
        box((0.6, 0.6, 1.6), Material("bricks", 1.05, roughness=0.9, relief=0.01), 0.3, 0.01).moved(
            width * 0.75, depth * 0.55, ridge - 0.8
        )
    )
    return group


def triangle(a: Sequence[float], b: Sequence[float], c: Sequence[float], material: Material) -> Mesh:
    """Return a triangle, counterclockwise from the front, upright in its texture: ``a`` to ``b`` is its lower edge."""
    corners = np.array([a, b, c], np.float64)
    right, normal = corners[1] - corners[0], np.cross(corners[1] - corners[0], corners[2] - corners[0])
    right = right / np.linalg.norm(right)
    up = np.cross(normal / np.linalg.norm(normal), right)
    coordinates = np.stack([(corners - corners[0]) @ right, -(corners - corners[0]) @ up], 1)
    normals = np.repeat(unit(normal[None]), 3, axis=0)
    return Mesh(
        corners.astype(np.float32), normals, coordinates.astype(np.float32), np.array([[0, 1, 2]], np.int32), material
    )


def garden_wall(length: float, rng: Generator) -> Group:
    """Return a garden wall along x with a coping and piers, centred at the origin."""
    name, size = (("bricks", 1.05), ("rubble", 1.8), ("plaster", 2.5))[int(rng.integers(3))]
    height = rng.uniform(0.9, 1.8)
    face = Material(name, size, roughness=0.9, relief=0.012)
    cap = Material("stone", 1.0, roughness=0.8, relief=0.005)
    group: Group = [
        box((length, 0.28, height), face, 0.3, 0.01),
        box((length + 0.1, 0.38, 0.07), cap, 0.3, 0.015).moved(0, 0, height),
    ]
    for x in np.linspace(-length / 2, length / 2, 4):
        group.append(box((0.42, 0.42, height + 0.2), face, 0.25, 0.012).moved(x, 0, 0))
        group.append(box((0.5, 0.5, 0.08), cap, 0.25, 0.015).moved(x, 0, height + 0.2))
    return group
