"""What lies around a garden: weather, terrain, paving, planting, walls, a house, woods and hills."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from avs.datasets.embedded.geometry.mesh_model import Array, Group, Material, moved, turned
from avs.datasets.embedded.geometry.shapes import ball, box, displaced, ground, lathe
from avs.datasets.embedded.light.light_sources import Lighting, Sky, Sun
from avs.datasets.embedded.materials.noise import SpaceNoise, lumps
from avs.datasets.embedded.materials.palette import blossom
from avs.datasets.embedded.things.buildings import garden_wall, house
from avs.datasets.embedded.things.furniture import trestle
from avs.datasets.embedded.things.plants import LEAF, hedge, leaves, rock, scatter, shrub, tree, tufts
from avs.datasets.embedded.things.props import carton, potted_plant, vase

Generator = np.random.Generator
Height = Callable[[Array], Array]
"""The terrain: maps ``[n, 2]`` places to ``[n]`` metres."""
Placed = tuple[Group, float, float, float]
"""A thing, its distance from the middle, its direction in radians, and how deep it is sunk into the ground."""


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


def terrain(rng: Generator, court: float, flat: float, reach: float = 140.0) -> tuple[Group, Height]:
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


def surroundings(
    rng: Generator, clear: float, height: Height, facing: float | None = None, house_too: bool = True
) -> Group:
    """Return everything beyond radius ``clear``: planting, a house, walls, trees near and far.

    Args:
        rng: draws it all.
        clear: radius that is kept free for the camera.
        height: of the terrain.
        facing: direction in radians in which the house stands; by default any.
        house_too: whether there is a house.
    """
    facing = rng.uniform(0, 2 * np.pi) if facing is None else facing
    places: list[Placed] = []
    if house_too:
        places.append((turned(house(rng), facing - np.pi / 2), clear + rng.uniform(3.5, 6.0), facing, 0.1))
    for side, build in (
        (1.35, garden_wall(rng.uniform(7, 11), rng)),
        (2.6, hedge(rng.uniform(6, 10), 0.7, rng.uniform(0.9, 1.6), rng)),
        (4.2, garden_wall(rng.uniform(5, 8), rng)),
    ):
        angle = facing + side + 0.2 * rng.normal()
        places.append((turned(build, angle - np.pi / 2), clear + rng.uniform(1.5, 4.0), angle, 0.02))
    places.append((turned(trestle(1.5, rng), facing + 2.0 - np.pi / 2), clear + 0.6, facing + 2.0, 0.02))
    places += _planting(rng, clear, facing)
    group = _tree_line(rng, height) + _ground_cover(rng, clear, height)
    for thing, radius, angle, sink in places:
        x, y = radius * np.cos(angle), radius * np.sin(angle)
        group += moved(thing, x, y, float(height(np.array([[x, y]], np.float32))[0]) - sink)
    return group


def _planting(rng: Generator, clear: float, facing: float) -> list[Placed]:
    """Return shrubs, trees near and far, boulders and pots; the near trees leave the direction ``facing`` open."""
    places: list[Placed] = []
    for _ in range(int(rng.integers(13, 19))):
        flower = blossom(rng) if rng.random() < 0.5 else None
        radius = rng.uniform(0.3, 0.9)
        bush = shrub(radius, int(420 * radius + 150), rng, flower)
        places.append((bush, clear + radius + rng.uniform(0.1, 4.0), rng.uniform(0, 2 * np.pi), 0.05))
    for _ in range(5):
        one = tree(rng.uniform(3.0, 5.0), 1800, rng)
        places.append((one, clear + rng.uniform(1.2, 6.0), facing + rng.uniform(0.7, 5.6), 0.05))
    for _ in range(6):
        one = tree(rng.uniform(5.0, 9.0), 900, rng, 0.2)
        places.append((one, clear + rng.uniform(9, 22), rng.uniform(0, 2 * np.pi), 0.1))
    for _ in range(7):
        radius = rng.uniform(0.15, 0.5)
        places.append(([rock(radius, rng)], clear + radius + rng.uniform(0.0, 3.0), rng.uniform(0, 2 * np.pi), 0.02))
    for _ in range(5):
        pot = potted_plant(rng, rng.uniform(0.18, 0.32))
        places.append((pot, clear + rng.uniform(0.3, 1.2), rng.uniform(0, 2 * np.pi), 0.02))
    return places


def _ground_cover(rng: Generator, clear: float, height: Height) -> Group:
    """Return tufts of grass, and fallen leaves."""
    spots = scatter(900, clear * 0.9, clear + 7, rng)
    grass = tufts(np.concatenate([spots, height(spots)[:, None]], 1), rng)
    litter = scatter(220, 0.3, clear + 3, rng)
    fallen = np.concatenate([litter, height(litter)[:, None] + 0.03], 1)
    flat = rng.normal(size=fallen.shape) * np.array([1, 1, 0.1])
    return [grass, leaves(fallen, flat, rng.uniform(0.04, 0.08, len(fallen)), LEAF.tinted(0.5, 0.3, 0.1), rng, 0.1)]


def _tree_line(rng: Generator, height: Height) -> Group:
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


def clutter(rng: Generator, inner: float, outer: float, count: int) -> Group:
    """Return ``count`` things that stand about on a ring: pots, crates, stones, a bench, shrubs in tubs, a birdbath."""
    group: Group = []
    start, kinds = rng.uniform(0, 2 * np.pi), rng.permutation(10)
    for k in range(count):
        # The golden angle keeps neighbours apart whatever their number is.
        angle, distance = start + 2.4 * k + 0.15 * rng.normal(), rng.uniform(inner, outer)
        kind = int(kinds[k % 10])
        if kind in (0, 5):
            thing: Group = [m.scaled(2.5, 2.5, 2.2) for m in carton(rng)]
            thing += moved(turned([m.scaled(1.8, 1.8, 1.8) for m in carton(rng)], rng.uniform(0, 6)), 0.5, 0.1, 0)
        elif kind in (1, 6):
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
