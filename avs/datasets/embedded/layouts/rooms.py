"""Rooms: rectangles with walls, doors and windows, and a frame of reference for each of the four walls."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from avs.datasets.embedded.geometry.mesh_model import Group, Material, Mesh, moved, rotation_about, turned
from avs.datasets.embedded.geometry.shapes import box, quad, surface
from avs.datasets.embedded.light.light_sources import Window
from avs.datasets.embedded.materials.palette import CLOTH, color, paint
from avs.datasets.embedded.things.buildings import Opening, casement, wall

Generator = np.random.Generator

NORTH, EAST, SOUTH, WEST = range(4)
OUTER, INNER = 0.3, 0.12
"""Thickness of outer walls, and of the walls between rooms, in metres."""


@dataclass
class Room:
    """One rectangular room. Walls are numbered north, east, south, west.

    Attributes:
        x0, y0, x1, y1: extent on the floor, metres.
        height: of the ceiling.
        use: what it is furnished for.
        doors: per wall, openings down to the floor, as (left, 0, width, height) seen from inside.
        windows: per wall, likewise.
    """

    x0: float
    y0: float
    x1: float
    y1: float
    height: float
    use: str
    doors: dict[int, list[Opening]] = field(default_factory=dict)
    windows: dict[int, list[Opening]] = field(default_factory=dict)

    @property
    def center(self) -> tuple[float, float]:
        """Middle of the floor."""
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    def length(self, side: int) -> float:
        """Return the length of the wall ``side``."""
        return self.x1 - self.x0 if side in (NORTH, SOUTH) else self.y1 - self.y0

    def openings(self, side: int) -> list[Opening]:
        """Return doors and windows of the wall ``side``."""
        return self.doors.get(side, []) + self.windows.get(side, [])

    def against(self, side: int, group: Iterable[Mesh]) -> Group:
        """Move ``group`` from a wall's own frame into the room.

        In that frame x runs along the wall from its left end seen from inside, the wall is at y = 0, the room at y < 0.
        """
        angle, (x, y) = self._frame(side)
        return moved(turned(group, angle), x, y, 0)

    def spot(self, side: int, along: float, out: float = 0.0) -> tuple[float, float]:
        """Return the floor point ``along`` the wall ``side`` and ``out`` metres into the room."""
        angle, (x, y) = self._frame(side)
        local = rotation_about(angle, "z") @ np.array([along, -out, 0], np.float32)
        return float(local[0]) + x, float(local[1]) + y

    def _frame(self, side: int) -> tuple[float, tuple[float, float]]:
        corner = {
            NORTH: (self.x0, self.y1),
            EAST: (self.x1, self.y1),
            SOUTH: (self.x1, self.y0),
            WEST: (self.x0, self.y0),
        }
        return -np.pi / 2 * side, corner[side]


FLOORS = (
    ("planks", 1.3, 0.35),
    ("parquet", 1.6, 0.28),
    ("tiles", 1.2, 0.25),
    ("parquet", 1.2, 0.4),
    ("planks", 1.8, 0.3),
)


def shell(room: Room, rng: Generator) -> Group:
    """Return floor, ceiling, walls with openings, window frames, door frames, curtains and skirting of ``room``."""
    name, size, roughness = FLOORS[int(rng.integers(len(FLOORS)))]
    tone = rng.uniform(0.6, 1.2)
    floor = Material(name, size, (tone, tone, tone), roughness, relief=0.001)
    paper = ("plaster", "wallpaper", "plaster", "wallpaper", "weave")[int(rng.integers(5))]
    face = Material(paper, {"plaster": 2.5, "wallpaper": 0.9, "weave": 1.0}[paper], paint(rng), 0.9, relief=0.001)
    white = Material("plaster", 3.0, (1.25, 1.25, 1.25), 0.9)
    trim = Material("wood", 0.8, (1.5, 2.4, 4.2) if rng.random() < 0.6 else (0.7, 0.7, 0.7), 0.4)
    width, depth = room.x1 - room.x0, room.y1 - room.y0
    group: Group = [
        quad((room.x0, room.y0, 0), (width, 0, 0), (0, depth, 0), floor, 0.12),
        quad((room.x0, room.y1, room.height), (width, 0, 0), (0, -depth, 0), white, 0.3),
    ]
    for side in range(4):
        inner = bool(room.doors.get(side))
        thickness = INNER / 2 if inner else OUTER
        openings = room.openings(side)
        parts = wall(room.length(side), room.height, thickness, openings, face, white, 0.16, backed=False)
        for opening in room.windows.get(side, []):
            parts += casement(opening, thickness, white.tinted(1.3, 1.3, 1.3), False, 0.15)
            parts += _curtains(opening, rng)
        for opening in room.doors.get(side, []):
            parts += _architrave(opening, trim)
        parts += _skirting(room.length(side), room.doors.get(side, []), trim)
        group += room.against(side, parts)
    return group


def sky_lights(room: Room) -> tuple[Window, ...]:
    """Return the windows of ``room`` as sources of light."""
    lights = []
    for side, openings in room.windows.items():
        for left, bottom, width, height in openings:
            # Seen from inside, right x up points out of the wall into the room only when right runs to the left end.
            corner, other = room.spot(side, left, -0.02), room.spot(side, left + width, -0.02)
            right = (other[0] - corner[0], other[1] - corner[1], 0.0)
            lights.append(Window((corner[0], corner[1], bottom), right, (0.0, 0.0, height)))
    return tuple(lights)


def _architrave(opening: Opening, trim: Material) -> Group:
    left, _, w, h = opening
    group: Group = [
        box((0.09, 0.04, h + 0.09), trim, 0.25, 0.004).moved(x, -0.005, 0) for x in (left - 0.045, left + w + 0.045)
    ]
    group.append(box((w, 0.04, 0.09), trim, 0.25, 0.004).moved(left + w / 2, -0.005, h))
    return group


def _skirting(length: float, doors: list[Opening], trim: Material) -> Group:
    edges = [0.0, *(x for d in sorted(doors) for x in (d[0] - 0.09, d[0] + d[2] + 0.09)), length]
    return [
        box((b - a, 0.025, 0.09), trim, 0.3, 0.004).moved((a + b) / 2, -0.01, 0)
        for a, b in zip(edges[::2], edges[1::2], strict=True)
        if b - a > 0.05
    ]


def _curtains(opening: Opening, rng: Generator) -> Group:
    """Return a pair of drawn curtains beside a window, or none."""
    if rng.random() < 0.35:
        return []
    left, bottom, w, h = opening
    pattern = ("weave", "check", "carpet")[int(rng.integers(3))]
    cloth = Material(pattern, 0.6, color(rng, 0.5, 1.2), 0.95, translucency=0.25)
    group: Group = []
    top, low = bottom + h + 0.12, max(0.03, bottom - rng.choice([0.15, bottom - 0.03]))
    for start in (left - 0.32, left + w - 0.06):
        s, t = np.linspace(0, 1, 33), np.linspace(0, 1, 12)
        wave = 0.035 * np.sin(2 * np.pi * 5 * s)[None, :] * (0.6 + 0.4 * t[::-1])[:, None]
        x, z = np.broadcast_arrays(start + 0.38 * s[None, :], (low + (top - low) * t)[:, None])
        points = np.stack([x, -0.09 + wave, z], -1)
        coordinates = np.stack([np.broadcast_to(0.7 * s, x.shape), -z], -1)
        group.append(surface(points, coordinates, cloth))
    rod = box((w + 0.9, 0.025, 0.025), CLOTH.tinted(0.2, 0.15, 0.1), 0.3, 0.008)
    return [*group, rod.moved(left + w / 2, -0.09, top - 0.01)]
