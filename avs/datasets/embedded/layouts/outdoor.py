"""Gardens: a centre piece on paving, gravel or grass, within lawns, hedges, trees, a house, walls and far hills."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from avs.datasets.embedded.geometry.mesh_model import Group, Material, moved, turned
from avs.datasets.embedded.geometry.shapes import box
from avs.datasets.embedded.layouts.landscape import clutter, court_floor, daylight, surroundings, terrain
from avs.datasets.embedded.layouts.stage import Stage
from avs.datasets.embedded.materials.palette import blossom
from avs.datasets.embedded.things.buildings import house
from avs.datasets.embedded.things.furniture import chair, round_table, table, trestle
from avs.datasets.embedded.things.plants import creeper, shrub
from avs.datasets.embedded.things.props import arranged, carton, potted_plant, vase
from avs.datasets.embedded.things.sculpture import plinth, statue

Generator = np.random.Generator


def dining(rng: Generator) -> tuple[Group, float]:
    """Return a garden table that is laid, with chairs; and the height of its middle."""
    if rng.random() < 0.5:
        radius = rng.uniform(0.55, 0.75)
        group = round_table(radius, 0.74, rng)
    else:
        radius = 0.45
        group = table(rng.uniform(1.2, 1.6), 0.95, 0.74, rng)
    group += moved(arranged(radius * 0.95, int(rng.integers(7, 11)), rng), 0, 0, 0.742)
    seats = int(rng.integers(2, 5))
    start = rng.uniform(0, 2 * np.pi)
    design = int(rng.integers(1 << 30))
    for k in range(seats):
        angle = start + 2 * np.pi * (k + 0.25 * rng.normal()) / (seats + 0.7)
        one = turned(chair(np.random.default_rng(design)), angle - np.pi / 2 + 0.2 * rng.normal())
        distance = radius + rng.uniform(0.35, 0.6)
        group += moved(one, distance * np.cos(angle), distance * np.sin(angle), 0.005)
    return group, 0.75


def monument(rng: Generator) -> tuple[Group, float]:
    """Return a statue on a plinth among pots."""
    base = plinth(rng)
    top = float(max(mesh.vertices[:, 2].max() for mesh in base))
    group = base + moved(statue(rng, rng.uniform(1.0, 1.3)), 0, 0, top - 0.01)
    for k in range(int(rng.integers(4, 7))):
        angle = 2 * np.pi * (k + 0.3 * rng.normal()) / 6
        pot = potted_plant(rng, rng.uniform(0.14, 0.26))
        group += moved(pot, 0.95 * np.cos(angle), 0.95 * np.sin(angle), 0.005)
    return group, top + 0.35


def still_life(rng: Generator) -> tuple[Group, float]:
    """Return big jars, crates and pots on and around a low stone table."""
    slab = Material("stone", 1.0, roughness=0.75, relief=0.008)
    group: Group = [box((1.5, 0.85, 0.1), slab, 0.08, 0.02).moved(0, 0, 0.4)]
    group += [box((0.22, 0.6, 0.41), slab, 0.15, 0.02).moved(x, 0, 0).shifted(rng) for x in (-0.5, 0.5)]
    group += moved(arranged(0.42, 7, rng), 0.25, 0, 0.5)
    group += moved(vase(rng, 0.5), -0.5, 0.1, 0.5)
    for k in range(6):
        angle, distance = 2 * np.pi * (k + 0.3 * rng.normal()) / 6, rng.uniform(0.95, 1.25)
        thing = (
            potted_plant(rng, rng.uniform(0.15, 0.24))
            if rng.random() < 0.6
            else [m.scaled(2.4, 2.4, 2.0) for m in carton(rng)]
        )
        group += moved(turned(thing, rng.uniform(0, 6)), distance * np.cos(angle), distance * np.sin(angle), 0.005)
    return group, 0.6


CENTRE_PIECES: tuple[Callable[[Generator], tuple[Group, float]], ...] = (dining, monument, still_life)


def sculpture_court(rng: Generator) -> Stage:
    """Return a statue in a garden, seen from the side of the house's garden or of the house."""
    piece, middle = monument(rng)
    ring = rng.uniform(3.2, 4.0)
    court = ring * rng.uniform(0.6, 0.9)
    lawn, height = terrain(rng, court, ring + 3)
    heading = float(rng.uniform(0, 2 * np.pi))
    behind = heading + np.pi + float(rng.uniform(-0.8, 0.8))
    group = piece + lawn + court_floor(court, rng) + surroundings(rng, ring * 0.95, height, behind)
    group += clutter(rng, 1.4, ring * 0.85, 7)
    return Stage(tuple(group), daylight(rng, heading), (0.0, 0.0, middle + 0.1), ring, heading)


def facade(rng: Generator) -> Stage:
    """Return the front of a house with what stands before it: pots, a bench, shrubs, creepers, steps."""
    ring = rng.uniform(5.0, 6.0)
    lawn, height = terrain(rng, ring * 1.15, ring + 3)
    group = moved(house(rng), 0, 1.0, 0)
    group += court_floor(ring * 1.15, rng)
    for x in rng.permutation(np.arange(-3.5, 3.6, 0.7))[:8]:
        depth = rng.uniform(0.25, 0.6)
        kind = rng.random()
        if kind < 0.45:
            thing = potted_plant(rng, rng.uniform(0.15, 0.3))
        elif kind < 0.75:
            thing = shrub(rng.uniform(0.25, 0.5), 320, rng, blossom(rng) if rng.random() < 0.6 else None)
        else:
            thing = [m.scaled(2.6, 2.6, 2.2) for m in carton(rng)]
        group += moved(turned(thing, rng.uniform(-0.4, 0.4)), float(x), 1.0 - depth, 0)
    group += moved(turned(trestle(1.5, rng), rng.normal() * 0.1), rng.choice([-2.4, 2.4]), 0.2, 0)
    group += moved(creeper(rng, 2.6, 3.0), rng.choice([-3.2, 3.0]), 0.97, 0)
    for _ in range(3):
        angle, distance = -np.pi / 2 + rng.uniform(-1.2, 1.2), rng.uniform(1.6, 3.0)
        group += moved(potted_plant(rng, rng.uniform(0.2, 0.34)), distance * np.cos(angle), distance * np.sin(angle), 0)
    group += lawn + surroundings(rng, ring * 1.2, height, np.pi / 2, house_too=False)
    return Stage(tuple(group), daylight(rng, -np.pi / 2), (0.0, 0.6, 1.7), ring, -np.pi / 2)


def garden(rng: Generator) -> Stage:
    """Return a garden whose kind of centre piece, weather and planting ``rng`` draws."""
    piece, middle = CENTRE_PIECES[int(rng.integers(len(CENTRE_PIECES)))](rng)
    ring = rng.uniform(2.2, 2.6) + 0.45 * middle
    court = ring * rng.uniform(0.75, 1.15)
    lawn, height = terrain(rng, court, ring + 3)
    group = piece + lawn + court_floor(court, rng) + surroundings(rng, ring * 1.2 + 0.4, height)
    group += clutter(rng, 1.45, max(ring * 0.8, 1.7), int(rng.integers(7, 11)))
    return Stage(tuple(group), daylight(rng), (0.0, 0.0, middle), ring)
