"""Gardens: a centre piece on paving, gravel or grass, within lawns, hedges, trees, a house, walls and far hills."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from avs.datasets.embedded.buildings import garden_wall, house
from avs.datasets.embedded.furniture import chair, round_table, table, trestle
from avs.datasets.embedded.lighting import Lighting, Sky, Sun
from avs.datasets.embedded.model import Array, Group, Material, moved, turned
from avs.datasets.embedded.noise import SpaceNoise, lumps
from avs.datasets.embedded.plants import LEAF, creeper, hedge, leaves, rock, scatter, shrub, tree, tufts
from avs.datasets.embedded.props import arranged, blossom, carton, potted_plant, vase
from avs.datasets.embedded.sculpture import plinth, statue
from avs.datasets.embedded.shapes import ball, box, displaced, ground, lathe
from avs.datasets.embedded.stage import Stage

Generator = np.random.Generator


def daylight(rng: Generator, side: float | None = None) -> Lighting:
    """Return a sky of random weather with its sun, high enough to light the ground, on the ``side`` if given."""
    azimuth, elevation = rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.05)
    if side is not None:
        azimuth = side + rng.uniform(-1.1, 1.1)
    direction = (
        float(np.cos(azimuth) * np.cos(elevation)),
        float(np.sin(azimuth) * np.cos(elevation)),
        float(np.sin(elevation)),
    )
    cloudy = float(rng.uniform(0.15, 0.75))
    strength = 3.2 * (1 - 0.55 * cloudy)
    warm = 1 - 0.35 * (1.05 - elevation)
    sun = Sun(
        direction, (strength, strength * (0.5 + 0.45 * warm), strength * (0.25 + 0.6 * warm)), 0.005 + 0.015 * cloudy**2
    )
    blue = 1 - 0.6 * cloudy
    sky = Sky(
        (0.55 - 0.33 * blue, 0.6 - 0.2 * blue, 0.75 + 0.1 * blue),
        (0.85, 0.95, 1.05),
        (0.16, 0.16, 0.12),
        sun,
        cloudy,
        rng,
    )
    return Lighting(sky, sun, haze=1 / 800)


def terrain(rng: Generator, court: float, flat: float, reach: float = 140.0) -> tuple[Group, Callable[[Array], Array]]:
    """Return lawn from radius ``court`` outwards, level up to ``flat``, then hills; and its height function."""
    noise = SpaceNoise(rng)

    def height(plane: Array) -> Array:
        radius = np.hypot(plane[:, 0], plane[:, 1])
        rolling = noise(np.concatenate([plane * 0.07, np.zeros((len(plane), 1))], 1), 3)
        far = np.clip((radius - 45) / (reach - 45), 0, 1)
        hills = 22 * far**1.3 * (0.9 + noise(np.concatenate([plane * 0.022, np.full((len(plane), 1), 7.3)], 1), 3))
        return np.asarray(rolling * 1.2 * np.clip((radius - flat) / 15, 0, 1) + hills - 0.01, np.float32)

    near = np.linspace(court - 0.1, flat, 26)
    lawn = ground(
        np.concatenate([near, np.geomspace(flat * 1.06, 45, 22)]),
        height,
        Material("grass", 2.2, roughness=0.8, relief=0.02),
        128,
    )
    meadow = ground(np.geomspace(45, reach, 12), height, Material("grass", 9.0, (0.9, 0.95, 0.8), 0.9), 64)
    return [lawn, meadow], height


def court_floor(radius: float, rng: Generator) -> Group:
    """Return the floor under the centre piece, with a kerb of stones around it."""
    name, size = (("gravel", 1.6), ("paving", 2.0), ("cobbles", 1.8), ("grass", 2.0))[int(rng.integers(4))]
    noise = SpaceNoise(rng)
    floor = ground(
        np.linspace(0.02, radius, 34),
        lambda p: 0.012 * noise(np.concatenate([p, 0 * p[:, :1]], 1)),
        Material(name, size, roughness=0.8, relief=0.02),
        112,
    )
    count = int(2 * np.pi * radius / 0.42)
    kerb: Group = []
    if name != "grass":
        for k in range(count):
            tone = rng.uniform(0.6, 1.1)
            stone = box(
                (0.12, 0.38, 0.09 + 0.02 * rng.random()),
                Material("stone", 0.7, (tone, tone, tone * 0.95), 0.85, relief=0.005),
                0.2,
                0.02,
            )
            kerb.append(
                stone.shifted(rng).turned(rng.normal() * 0.05).moved(radius, 0, -0.02).turned(2 * np.pi * k / count)
            )
    return [floor, *kerb]


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


def surroundings(
    rng: Generator, clear: float, height: Callable[[Array], Array], facing: float | None = None, house_too: bool = True
) -> Group:
    """Return everything beyond radius ``clear``: planting, a house, walls, trees near and far.

    Args:
        rng: draws it all.
        clear: radius that is kept free for the camera.
        height: of the terrain.
        facing: direction in radians in which the house stands; by default any.
        house_too: whether there is a house.
    """
    group: Group = []

    def put(thing: Group, radius: float, angle: float, sink: float = 0.02) -> None:
        x, y = radius * np.cos(angle), radius * np.sin(angle)
        z = float(height(np.array([[x, y]], np.float32))[0])
        group.extend(moved(thing, x, y, z - sink))

    facing = rng.uniform(0, 2 * np.pi) if facing is None else facing
    distance = clear + rng.uniform(3.5, 6.0)
    if house_too:
        put(turned(house(rng), facing - np.pi / 2), distance, facing, 0.1)
    for side, build in (
        (1.35, garden_wall(rng.uniform(7, 11), rng)),
        (2.6, hedge(rng.uniform(6, 10), 0.7, rng.uniform(0.9, 1.6), rng)),
        (4.2, garden_wall(rng.uniform(5, 8), rng)),
    ):
        angle = facing + side + 0.2 * rng.normal()
        put(turned(build, angle - np.pi / 2), clear + rng.uniform(1.5, 4.0), angle)
    for _ in range(int(rng.integers(13, 19))):
        flower = blossom(rng) if rng.random() < 0.5 else None
        radius = rng.uniform(0.3, 0.9)
        put(
            shrub(radius, int(420 * radius + 150), rng, flower),
            clear + radius + rng.uniform(0.1, 4.0),
            rng.uniform(0, 2 * np.pi),
            0.05,
        )
    for _ in range(5):
        put(tree(rng.uniform(3.0, 5.0), 1800, rng), clear + rng.uniform(1.2, 6.0), facing + rng.uniform(0.7, 5.6), 0.05)
    for _ in range(6):
        put(tree(rng.uniform(5.0, 9.0), 900, rng, 0.2), clear + rng.uniform(9, 22), rng.uniform(0, 2 * np.pi), 0.1)
    for _ in range(7):
        radius = rng.uniform(0.15, 0.5)
        put([rock(radius, rng)], clear + radius + rng.uniform(0.0, 3.0), rng.uniform(0, 2 * np.pi))
    put(turned(trestle(1.5, rng), facing + 2.0 - np.pi / 2), clear + 0.6, facing + 2.0)
    for _ in range(5):
        put(potted_plant(rng, rng.uniform(0.18, 0.32)), clear + rng.uniform(0.3, 1.2), rng.uniform(0, 2 * np.pi))
    group += _tree_line(rng, height)
    spots = scatter(900, clear * 0.9, clear + 7, rng)
    group.append(tufts(np.concatenate([spots, height(spots)[:, None]], 1), rng))
    litter = scatter(220, 0.3, clear + 3, rng)
    fallen = np.concatenate([litter, height(litter)[:, None] + 0.03], 1)
    group.append(
        leaves(
            fallen,
            rng.normal(size=fallen.shape) * np.array([1, 1, 0.1]),
            rng.uniform(0.04, 0.08, len(fallen)),
            LEAF.tinted(0.5, 0.3, 0.1),
            rng,
            0.1,
        )
    )
    return group


def _tree_line(rng: Generator, height: Callable[[Array], Array]) -> Group:
    """Return distant woods: displaced crowns on the hills."""
    group: Group = []
    for _ in range(12):
        grove, distance, angle = int(rng.integers(2, 6)), rng.uniform(36, 95), rng.uniform(0, 2 * np.pi)
        tone = rng.uniform(0.6, 1.4)
        for _ in range(grove):
            x = distance * np.cos(angle) + rng.normal() * 5
            y = distance * np.sin(angle) + rng.normal() * 5
            z = float(height(np.array([[x, y]], np.float32))[0])
            radius = rng.uniform(1.3, 3.0)
            tint = (tone * rng.uniform(0.8, 1.3), tone, tone * rng.uniform(0.7, 1.1))
            for _ in range(3):
                crown = ball(radius, Material("foliage", radius * 1.3, tint, 0.8), radius * 0.5, rng.uniform(0.8, 1.3))
                crown = displaced(crown, lumps(SpaceNoise(rng), 0.7 * radius, 1.2 / radius))
                shift = rng.normal(size=3) * radius * np.array([0.5, 0.5, 0.25])
                group.append(crown.moved(x + shift[0], y + shift[1], z + shift[2] + 0.2 * radius))
    return group


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


def clutter(rng: Generator, inner: float, outer: float, count: int) -> Group:
    """Return ``count`` things that stand about on a ring: pots, crates, stones, a bench, shrubs in tubs, a birdbath."""
    group: Group = []
    start = rng.uniform(0, 2 * np.pi)
    for k in range(count):
        # The golden angle keeps neighbours apart whatever their number is.
        angle, distance = start + 2.4 * k + 0.15 * rng.normal(), rng.uniform(inner, outer)
        kind = int(rng.integers(6))
        if kind == 0:
            thing: Group = [m.scaled(2.5, 2.5, 2.2) for m in carton(rng)]
            thing += moved(turned([m.scaled(1.8, 1.8, 1.8) for m in carton(rng)], rng.uniform(0, 6)), 0.5, 0.1, 0)
        elif kind == 1:
            thing = [rock(rng.uniform(0.15, 0.3), rng)]
        elif kind == 2:
            thing = birdbath(rng)
        elif kind == 3:
            thing = moved(vase(rng, rng.uniform(0.4, 0.6)), 0, 0, 0)
        else:
            thing = potted_plant(rng, rng.uniform(0.14, 0.34))
        group += moved(turned(thing, rng.uniform(0, 6)), distance * np.cos(angle), distance * np.sin(angle), 0.004)
    return group


def birdbath(rng: Generator) -> Group:
    """Return a stone basin on a baluster, filled with water."""
    stone = Material("stone", 0.7, roughness=0.75, relief=0.003)
    profile = [
        (0, 0),
        (0.2, 0),
        (0.2, 0.06),
        (0.1, 0.12),
        (0.07, 0.3),
        (0.1, 0.45),
        (0.08, 0.62),
        (0.3, 0.72),
        (0.33, 0.78),
    ]
    water = Material("marble", 1.0, (0.05, 0.08, 0.08), 0.06, 0.04)
    scale = rng.uniform(0.8, 1.05)
    basin = lathe([*profile, (0.3, 0.78), (0.22, 0.71), (0, 0.7)], stone, 0.05, 28)
    return [m.scaled(scale, scale, scale) for m in (basin, lathe([(0.29, 0.755), (0, 0.755)], water, 0.1, 24))]


def garden(rng: Generator) -> Stage:
    """Return a garden whose kind of centre piece, weather and planting ``rng`` draws."""
    piece, middle = CENTRE_PIECES[int(rng.integers(len(CENTRE_PIECES)))](rng)
    ring = rng.uniform(2.2, 2.6) + 0.45 * middle
    court = ring * rng.uniform(0.75, 1.15)
    lawn, height = terrain(rng, court, ring + 3)
    group = piece + lawn + court_floor(court, rng) + surroundings(rng, ring * 1.2 + 0.4, height)
    group += clutter(rng, 1.45, max(ring * 0.8, 1.7), int(rng.integers(7, 11)))
    return Stage(tuple(group), daylight(rng), (0.0, 0.0, middle), ring)
