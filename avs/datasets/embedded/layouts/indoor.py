"""Furnished rooms with a laid table in the middle, in daylight through windows and under a hanging lamp."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avs.datasets.embedded.geometry.mesh_model import Group, Material, moved, turned
from avs.datasets.embedded.geometry.shapes import ground
from avs.datasets.embedded.layouts.furnishing import furnish
from avs.datasets.embedded.layouts.rooms import OUTER, Room, shell, sky_lights
from avs.datasets.embedded.layouts.stage import Stage
from avs.datasets.embedded.light.light_sources import Lamp, Lighting, Sky, Sun
from avs.datasets.embedded.things.centrepieces import laid_table, showpiece
from avs.datasets.embedded.things.furniture import pendant
from avs.datasets.embedded.things.plants import shrub, tree

Generator = np.random.Generator


def outlook(rooms: list[Room], rng: Generator) -> Group:
    """Return what is seen through the windows: a lawn with shrubs and trees."""
    corners = np.array([(r.x0, r.y0, r.x1, r.y1) for r in rooms])
    x, y = (corners[:, 0].min() + corners[:, 2].max()) / 2, (corners[:, 1].min() + corners[:, 3].max()) / 2
    reach = float(np.hypot(corners[:, 2].max() - x, corners[:, 3].max() - y)) + 1.5
    lawn = ground(
        np.geomspace(0.5, 120, 24), lambda p: np.full(len(p), -0.35), Material("grass", 3.0, roughness=0.9), 48
    )
    group: Group = [lawn.moved(x, y, 0)]
    for k in range(12):
        angle, distance = 2 * np.pi * (k + rng.random()) / 12, reach + rng.uniform(1.0, 8.0)
        thing = tree(rng.uniform(4, 7), 700, rng) if k % 2 else shrub(rng.uniform(0.5, 0.9), 220, rng)
        group += moved(thing, x + distance * np.cos(angle), y + distance * np.sin(angle), -0.4)
    return group


def room_light(rooms: list[Room], lamps: tuple[Lamp, ...], rng: Generator) -> Lighting:
    """Return daylight that enters through the windows of ``rooms``, with the sun before one of them, and ``lamps``."""
    facing = [(room, side) for room in rooms for side in room.windows]
    room, side = facing[int(rng.integers(len(facing)))]
    inside, outside = room.spot(side, 0, 1.0), room.spot(side, 0, 0.0)
    azimuth = np.arctan2(outside[1] - inside[1], outside[0] - inside[0]) + rng.uniform(-0.7, 0.7)
    elevation = rng.uniform(0.35, 0.75)
    direction = (
        float(np.cos(azimuth) * np.cos(elevation)),
        float(np.sin(azimuth) * np.cos(elevation)),
        float(np.sin(elevation)),
    )
    strength = float(rng.uniform(1.5, 5.0))
    sun = Sun(direction, (strength, 0.85 * strength, 0.66 * strength), 0.005)
    sky = Sky((0.75, 0.95, 1.3), (1.5, 1.6, 1.7), (0.35, 0.38, 0.25), sun, float(rng.uniform(0.2, 0.8)), rng)
    extent = np.array([(r.x0, r.y0, r.x1, r.y1) for r in rooms])
    box = (
        extent[:, 0].min() - OUTER,
        extent[:, 1].min() - OUTER,
        extent[:, 2].max() + OUTER,
        extent[:, 3].max() + OUTER,
    )
    windows = tuple(window for room in rooms for window in sky_lights(room))
    return Lighting(sky, sun, lamps, windows, interior=tuple(float(v) for v in box))  # type: ignore[arg-type]


def dining_room(rng: Generator) -> Stage:
    """Return one furnished room around a laid table; walls, furniture, light and table are drawn by ``rng``."""
    return _room(rng, *laid_table(rng), 1.95)


def showroom(rng: Generator) -> Stage:
    """Return one furnished room around a small table with one large object and a few small ones."""
    group, top = showpiece(rng)
    stage = _room(rng, group, top, 1.35)
    return replace(stage, target=(0.0, 0.0, top + 0.18))


def _room(rng: Generator, piece: Group, top: float, radius: float) -> Stage:
    """Return one furnished room around ``piece``, the top of whose table is at height ``top``."""
    half_x, half_y = rng.uniform(2.9, 3.5), rng.uniform(2.6, 3.1)
    room = Room(
        -half_x,
        -half_y,
        half_x,
        half_y,
        float(rng.uniform(2.5, 2.9)),
        ("dining", "living", "kitchen", "study")[int(rng.integers(4))],
    )
    first = int(rng.integers(4))
    for side in (first, (first + int(rng.integers(1, 3))) % 4):
        length = room.length(side)
        count = int(rng.integers(1, 3))
        width = float(rng.uniform(0.9, 1.3))
        room.windows[side] = [
            (length * (k + 0.5) / count - width / 2, 0.85, width, float(rng.uniform(1.25, 1.5))) for k in range(count)
        ]
    free = [side for side in range(4) if side not in room.windows]
    room.doors[free[0]] = [(room.length(free[0]) * rng.uniform(0.1, 0.6), 0.0, 0.95, 2.05)]
    group = shell(room, rng) + furnish(room, rng) + outlook([room], rng)
    hall = _hall(room, free[0])
    group += shell(hall, rng)
    group += turned(piece, rng.uniform(0, 2 * np.pi))
    lamp_height = top + float(rng.uniform(0.95, 1.1))
    group += pendant(room.height, lamp_height, rng)
    power = float(rng.uniform(0.2, 0.55))
    lamp = Lamp((0.0, 0.0, lamp_height + 0.01), (power, power * 0.8, power * 0.52), 0.03, True)
    return Stage(tuple(group), room_light([room, hall], (lamp,), rng), (0.0, 0.0, top + 0.05), radius)


def _hall(room: Room, side: int) -> Room:
    """Return a small hall behind the door, so that it does not open into the garden."""
    left, _, width, _ = room.doors[side][0]
    x, y = room.spot(side, left + width / 2, -1.4)
    hall = Room(x - 1.3, y - 1.3, x + 1.3, y + 1.3, room.height, "study")
    hall.doors[(side + 2) % 4] = [(1.3 - width / 2, 0.0, width, 2.05)]
    hall.windows[side] = [(0.75, 0.9, 1.1, 1.3)]
    return hall
