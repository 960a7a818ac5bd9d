"""Flats of several furnished rooms, connected by doors; the walk through them, and the flat as one coloured mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avs.datasets.embedded.geometry.mesh_model import Group, moved, turned
from avs.datasets.embedded.layouts.furnishing import furnish
from avs.datasets.embedded.layouts.indoor import outlook, room_light
from avs.datasets.embedded.layouts.rooms import EAST, INNER, NORTH, SOUTH, WEST, Room, shell
from avs.datasets.embedded.layouts.stage import Stage
from avs.datasets.embedded.light.light_sources import Lamp
from avs.datasets.embedded.things.buildings import Opening
from avs.datasets.embedded.things.centrepieces import laid_table, low_table
from avs.datasets.embedded.things.furniture import pendant

Generator = np.random.Generator
Path = tuple[tuple[float, float], ...]

DOOR_WIDTH, DOOR_HEIGHT = 0.95, 2.05
_USES = ("living", "kitchen", "bedroom", "dining", "study", "living")


@dataclass(frozen=True)
class Flat:
    """A furnished flat.

    Attributes:
        rooms: in the order of a walk: each has a door to the next.
        meshes: everything in and around them.
        lamps: hanging in the rooms.
        path: points of the walk on the floor.
    """

    rooms: tuple[Room, ...]
    meshes: tuple[Group, ...]
    lamps: tuple[Lamp, ...]
    path: Path


def floor_plan(rows: int, columns: int, rng: Generator) -> list[Room]:
    """Return ``rows`` x ``columns`` rooms in serpentine order, with doors between successive ones, and windows."""
    xs = np.concatenate([[0.0], np.cumsum(rng.uniform(3.6, 4.9, columns))])
    ys = np.concatenate([[0.0], np.cumsum(rng.uniform(3.5, 4.6, rows))])
    height, half = float(rng.uniform(2.5, 2.8)), INNER / 2
    cells = [(r, c if r % 2 == 0 else columns - 1 - c) for r in range(rows) for c in range(columns)]
    uses = [_USES[int(k)] for k in rng.permutation(len(_USES))]
    rooms = [
        Room(
            float(xs[c]) + half,
            float(ys[r]) + half,
            float(xs[c + 1]) - half,
            float(ys[r + 1]) - half,
            height,
            uses[k % 6],
        )
        for k, (r, c) in enumerate(cells)
    ]
    index = {cell: k for k, cell in enumerate(cells)}
    for k, (r, c) in enumerate(cells):
        for (dr, dc), side in (((0, 1), EAST), ((1, 0), NORTH)):
            other = index.get((r + dr, c + dc))
            if other is not None and (abs(other - k) == 1 or rng.random() < 0.35):
                _connect(rooms[k], rooms[other], side, rng)
        for (dr, dc), side in (((0, 1), EAST), ((1, 0), NORTH), ((0, -1), WEST), ((-1, 0), SOUTH)):
            if (r + dr, c + dc) not in index:
                rooms[k].windows[side] = _windows(rooms[k].length(side), rng)
    return rooms


def _connect(room: Room, other: Room, side: int, rng: Generator) -> None:
    """Open a door from ``room`` through its wall ``side`` (east or north) to ``other``."""
    place = float(rng.uniform(0.3, 0.7))
    along = place * room.length(side)
    # Seen from the other room, the same wall runs the other way round.
    back = other.length((side + 2) % 4) - along
    room.doors.setdefault(side, []).append((along - DOOR_WIDTH / 2, 0.0, DOOR_WIDTH, DOOR_HEIGHT))
    other.doors.setdefault((side + 2) % 4, []).append((back - DOOR_WIDTH / 2, 0.0, DOOR_WIDTH, DOOR_HEIGHT))


def _windows(length: float, rng: Generator) -> list[Opening]:
    count = 2 if length > 4.2 and rng.random() < 0.5 else 1
    width = float(rng.uniform(0.9, 1.3))
    return [(length * (k + 0.5) / count - width / 2, 0.85, width, float(rng.uniform(1.25, 1.45))) for k in range(count)]


def flat(rows: int, columns: int, rng: Generator) -> Flat:
    """Return a furnished flat of ``rows`` x ``columns`` rooms."""
    rooms = floor_plan(rows, columns, rng)
    meshes: list[Group] = [outlook(rooms, rng)]
    lamps, path = [], []
    for k, room in enumerate(rooms):
        meshes += [shell(room, rng), furnish(room, rng)]
        x, y = room.center
        piece, _ = (laid_table if room.use in ("kitchen", "dining") else low_table)(rng)
        # The table stands off the middle, the walk passes on its other side.
        shift = rng.choice([-1.0, 1.0], 2) * np.array([0.35, 0.3])
        meshes.append(moved(turned(piece, float(rng.choice([0.0, np.pi / 2]))), x + shift[0], y + shift[1], 0))
        lamp_height = room.height - 0.45
        meshes.append(moved(pendant(room.height, lamp_height, rng), x + shift[0], y + shift[1], 0))
        power = float(rng.uniform(0.4, 1.0))
        lamps.append(Lamp((x + shift[0], y + shift[1], lamp_height + 0.01), (power, power * 0.8, power * 0.55), 0.03))
        if k:
            path += _threshold(rooms[k - 1], room)
        path.append((x - 2.2 * float(shift[0]), y - 2.2 * float(shift[1])))
    return Flat(tuple(rooms), tuple(meshes), tuple(lamps), tuple(path))


def _threshold(room: Room, other: Room) -> list[tuple[float, float]]:
    """Return points before, in and behind the door from ``room`` to ``other``."""
    for side, doors in room.doors.items():
        for left, _, width, _ in doors:
            x, y = room.spot(side, left + width / 2, -INNER / 2)
            if other.x0 - INNER < x < other.x1 + INNER and other.y0 - INNER < y < other.y1 + INNER:
                return [room.spot(side, left + width / 2, 0.7), (x, y), room.spot(side, left + width / 2, -0.8)]
    raise ValueError("successive rooms share no door")


def walk_stage(rng: Generator) -> Stage:
    """Return a flat of three or four rooms with the walk through them."""
    rows, columns = ((1, 3), (2, 2), (3, 1))[int(rng.integers(3))]
    home = flat(rows, columns, rng)
    path = home.path if rng.random() < 0.5 else home.path[::-1]
    group = tuple(mesh for part in home.meshes for mesh in part)
    x, y = home.rooms[0].center
    return Stage(group, room_light(list(home.rooms), home.lamps, rng), (x, y, 1.2), 1.5, path=path)
