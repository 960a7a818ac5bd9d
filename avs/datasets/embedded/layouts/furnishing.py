"""Furnishing of rooms: pieces along the walls where there is space, pictures above them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from avs.datasets.embedded.geometry.mesh_model import Group, moved, scaled, turned
from avs.datasets.embedded.layouts.rooms import Room
from avs.datasets.embedded.things.books import book_stack
from avs.datasets.embedded.things.buildings import Opening
from avs.datasets.embedded.things.furniture import (
    bed,
    bookcase,
    cabinet,
    chair,
    floor_lamp,
    framed_picture,
    kitchenette,
    sofa,
    table,
)
from avs.datasets.embedded.things.props import arranged, candle_stick, carton, potted_plant, vase

Generator = np.random.Generator

# Per piece: how it is made, its least and greatest width, its height; high ones keep clear of windows.
PIECES: dict[str, tuple[Callable[[float, Generator], Group], float, float, float]] = {
    "bookcase": (lambda w, rng: bookcase(w, float(rng.uniform(1.5, 2.1)), rng), 0.8, 1.6, 2.1),
    "cabinet": (lambda w, rng: _topped(cabinet(w, 0.8, rng), w, 0.8, rng), 0.7, 1.3, 0.8),
    "sofa": (lambda w, rng: sofa(w, rng), 1.5, 2.2, 0.85),
    "armchair": (lambda w, rng: sofa(w, rng), 0.9, 1.0, 0.85),
    "bed": (lambda w, rng: bed(w, rng), 1.0, 1.7, 1.0),
    "kitchen": (lambda w, rng: kitchenette(w, rng), 1.5, 3.2, 0.95),
    "desk": (lambda w, rng: _desk(w, rng), 1.1, 1.5, 0.75),
    "plant": (lambda w, rng: moved(scaled(potted_plant(rng, 0.17), 1.3), 0, -0.3, 0), 0.55, 0.6, 0.8),
    "lamp": (lambda w, rng: moved(floor_lamp(rng), 0, -0.3, 0), 0.5, 0.55, 1.6),
    "boxes": (lambda w, rng: _boxes(rng), 0.6, 0.9, 0.7),
}

USES: dict[str, tuple[str, ...]] = {
    "living": ("sofa", "bookcase", "cabinet", "plant", "armchair", "lamp", "bookcase", "plant", "boxes", "cabinet"),
    "dining": ("cabinet", "bookcase", "plant", "cabinet", "lamp", "plant", "armchair", "boxes", "bookcase"),
    "kitchen": ("kitchen", "kitchen", "cabinet", "plant", "bookcase", "boxes", "plant"),
    "bedroom": ("bed", "cabinet", "lamp", "bookcase", "plant", "armchair", "boxes", "desk"),
    "study": ("desk", "bookcase", "bookcase", "armchair", "plant", "lamp", "boxes", "cabinet"),
}


def furnish(room: Room, rng: Generator) -> Group:
    """Return furniture along the walls of ``room``, and pictures above the low pieces and on bare walls."""
    group: Group = []
    wanted = list(USES[room.use])
    taken_corner = [0.0] * 4  # depth that the neighbour on the left takes from each wall's start
    for side in rng.permutation(4).tolist():
        position = 0.05 + taken_corner[side]
        length = room.length(side) - 0.05 - taken_corner[(side + 1) % 4]
        while position < length - 0.5 and wanted:
            blocked = _first_conflict(room.doors.get(side, []), position, 0.5, 0.12)
            if blocked is not None:
                position = blocked[0] + blocked[2] + 0.14
                continue
            name = wanted.pop(0)
            make, least, greatest, height = PIECES[name]
            low = _first_conflict(room.windows.get(side, []), position, least, 0.05) if height > 0.9 else None
            limit = min([length, *(d[0] - 0.14 for d in room.doors.get(side, []) if d[0] > position)])
            if low is not None or position + least > limit:
                wanted.append(name)
                if all(position + PIECES[n][1] > limit or (PIECES[n][3] > 0.9 and low is not None) for n in wanted):
                    position = limit + 0.14 if limit < length else length
                    position += 0.2
                continue
            width = float(min(rng.uniform(least, greatest), limit - position))
            group += room.against(side, moved(make(width, rng), position + width / 2, -0.012, 0))
            if height < 1.2:
                group += _picture_above(room, side, position, width, max(height, 1.0), rng)
            position += width + float(rng.uniform(0.05, 0.6))
        if position > 0.9:
            taken_corner[(side + 1) % 4] = 0.95
        taken_corner[side] = max(taken_corner[side], 0.0)
        group += _pictures_on_bare(room, side, position, length, rng)
    return group


def _first_conflict(openings: Sequence[Opening], start: float, width: float, margin: float) -> Opening | None:
    for opening in sorted(openings):
        if opening[0] - margin < start + width and opening[0] + opening[2] + margin > start:
            return opening
    return None


def _topped(group: Group, width: float, height: float, rng: Generator) -> Group:
    """Put a few things on a low piece."""
    things = (vase, book_stack, candle_stick, carton)
    for x in np.arange(-width / 2 + 0.18, width / 2 - 0.1, 0.36):
        if rng.random() < 0.75:
            group = group + moved(things[int(rng.integers(len(things)))](rng), float(x), -0.2, height + 0.001)
    return group


def _desk(width: float, rng: Generator) -> Group:
    group = moved(table(width, 0.65, 0.74, rng), 0, -0.34, 0)
    group += moved(arranged(0.3, 5, rng), -0.2, -0.34, 0.742)
    return group + moved(turned(chair(rng), np.pi + 0.4 * rng.normal()), 0.1, -0.95, 0)


def _boxes(rng: Generator) -> Group:
    group: Group = moved(scaled(carton(rng), 2.2), -0.05, -0.25, 0)
    return (
        group
        + moved(turned(scaled(carton(rng), 1.8), 0.4), 0.22, -0.5, 0)
        + moved(turned(book_stack(rng), 0.3), -0.2, -0.6, 0)
    )


def _picture_above(room: Room, side: int, start: float, width: float, height: float, rng: Generator) -> Group:
    if _first_conflict(room.windows.get(side, []), start - 0.1, width + 0.2, 0.35) is not None or rng.random() < 0.2:
        return []
    size = float(min(rng.uniform(0.4, 0.8), width * 0.8))
    tall = size * float(rng.uniform(0.75, 1.2))
    middle = min(height + 0.2 + tall / 2, room.height - 0.25 - tall / 2)
    return room.against(side, moved(framed_picture(size, tall, rng), start + width / 2, 0, middle))


def _pictures_on_bare(room: Room, side: int, start: float, end: float, rng: Generator) -> Group:
    group: Group = []
    position = start + 0.3
    while position < end - 0.7:
        size = float(rng.uniform(0.35, 0.7))
        conflict = _first_conflict(room.openings(side), position, size, 0.4)
        if conflict is not None:
            position = conflict[0] + conflict[2] + 0.45
            continue
        picture = framed_picture(size, size * float(rng.uniform(0.75, 1.25)), rng)
        group += room.against(side, moved(picture, position + size / 2, 0, float(rng.uniform(1.45, 1.65))))
        position += size + float(rng.uniform(0.3, 1.2))
    return group
