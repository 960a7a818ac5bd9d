"""Tables with what is on them and around them, for the middle of rooms."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from avs.datasets.embedded.geometry.mesh_model import Group, moved, scaled, turned
from avs.datasets.embedded.things.books import book
from avs.datasets.embedded.things.furniture import chair, round_table, rug, table
from avs.datasets.embedded.things.props import arranged, carton, fruit, mug, potted_plant, teapot, vase
from avs.datasets.embedded.things.sculpture import statue

Generator = np.random.Generator

_GAP = 0.001
"""Metres between a top and what stands on it: equal heights would make their surfaces flicker."""


def low_table(rng: Generator) -> tuple[Group, float]:
    """Return a coffee table on a rug."""
    height = 0.44
    group = _rug(rng) + table(1.1, 0.65, height, rng)
    return group + moved(arranged(0.3, 5, rng), 0, 0, height + _GAP), height


def laid_table(rng: Generator) -> tuple[Group, float]:
    """Return a laid dining table, round or rectangular, with chairs, on a rug."""
    height, group = 0.75, _rug(rng)
    if rng.random() < 0.5:
        reach_x = reach_y = rng.uniform(0.5, 0.65)
        group += round_table(reach_x, height, rng)
        group += moved(arranged(reach_x * 0.92, int(rng.integers(7, 11)), rng), 0, 0, height + _GAP)
    else:
        reach_x, reach_y = rng.uniform(0.65, 0.8), 0.45
        group += table(2 * reach_x, 2 * reach_y, height, rng)
        for x, radius, count in ((-reach_x + 0.2, 0.18, 2), (0.0, reach_x - 0.38, 6), (reach_x - 0.2, 0.18, 2)):
            group += moved(arranged(radius, count, rng), x, 0, height + _GAP)
    return group + _chairs(rng, reach_x, reach_y), height


def showpiece(rng: Generator) -> tuple[Group, float]:
    """Return a small round table with one large object and a few small ones, and two chairs, on a rug."""
    height = 0.75
    objects: tuple[Callable[[], Group], ...] = (
        lambda: statue(rng, 0.42),
        lambda: vase(rng, 0.34),
        lambda: potted_plant(rng, 0.14),
        lambda: scaled(teapot(rng), 2.0),
    )
    group = _rug(rng) + round_table(0.47, height, rng)
    group += moved(turned(objects[int(rng.integers(4))](), rng.uniform(0, 2 * np.pi)), 0, 0, height + _GAP)
    for k in range(6):
        angle = 2 * np.pi * (k + 0.3 * rng.normal()) / 6
        thing = turned((mug, fruit, book, carton)[int(rng.integers(4))](rng), rng.uniform(0, 6))
        group += moved(thing, 0.33 * np.cos(angle), 0.33 * np.sin(angle), height + _GAP)
    for _ in range(2):
        angle = rng.uniform(0, 2 * np.pi)
        group += moved(turned(chair(rng), angle), 0.95 * np.cos(angle), 0.95 * np.sin(angle), 0.013)
    return group, height


def _rug(rng: Generator) -> Group:
    return rug(rng.uniform(2.2, 3.0), rng.uniform(1.7, 2.2), rng)


def _chairs(rng: Generator, reach_x: float, reach_y: float) -> Group:
    """Return two to four chairs of one kind around a table of the given half extents, pushed back at will."""
    group: Group = []
    design, seats, start = int(rng.integers(1 << 30)), int(rng.integers(2, 5)), rng.uniform(0, 2 * np.pi)
    for k in range(seats):
        angle, out = start + 2 * np.pi * (k + 0.2 * rng.normal()) / seats, rng.uniform(0.3, 0.5)
        seat = turned(chair(np.random.default_rng(design)), angle - np.pi / 2 + 0.25 * rng.normal())
        group += moved(seat, (reach_x + out) * np.cos(angle), (reach_y + out) * np.sin(angle), 0.013)
    return group
