"""Things: crockery, fruit, packets, bottles, pots and cushions. Each stands at the origin."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from avs.datasets.embedded.geometry.mesh_model import Group, Material, Mesh, moved, turned
from avs.datasets.embedded.geometry.shapes import ball, box, cylinder, displaced, lathe, quad, surface, tube
from avs.datasets.embedded.materials.noise import SpaceNoise
from avs.datasets.embedded.materials.palette import (
    CARDBOARD,
    CERAMIC,
    GLASS,
    GLAZED,
    STEEL,
    TERRACOTTA,
    WAX,
    WOOD,
    blossom,
    color,
    picture,
)
from avs.datasets.embedded.materials.textures import PICTURES
from avs.datasets.embedded.things.books import book_stack
from avs.datasets.embedded.things.plants import bouquet, shrub

Generator = np.random.Generator


def mug(rng: Generator) -> Group:
    """Return a mug with a handle and coffee in it."""
    material = (CERAMIC if rng.random() < 0.5 else GLAZED).tinted(*color(rng, 0.5, 1.2))
    r, h = rng.uniform(0.036, 0.045), rng.uniform(0.085, 0.11)
    wall = [
        (0, 0),
        (r * 0.92, 0),
        (r * 0.92, 0),
        (r, 0.01),
        (r, h),
        (r - 0.004, h + 0.002),
        (r - 0.006, h),
        (r - 0.006, h * 0.8),
    ]
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 9)
    path = np.stack([r + 0.024 * np.cos(angle), 0 * angle, h / 2 + 0.032 * np.sin(angle)], 1)
    coffee = lathe([(r - 0.005, h * 0.8), (0, h * 0.8)], Material("wood", 0.2, (0.2, 0.12, 0.08), 0.1), 0.05)
    return [lathe(wall, material, 0.03, 24), tube(path, np.full(9, 0.006), material), coffee]


def bottle(rng: Generator) -> Group:
    """Return a bottle with a label."""
    r, h = rng.uniform(0.032, 0.042), rng.uniform(0.24, 0.32)
    glass = GLASS.tinted(*color(rng, 0.03, 0.25))
    shape = [
        (0, 0),
        (r, 0),
        (r, 0),
        (r, h * 0.62),
        (r * 0.75, h * 0.72),
        (r * 0.36, h * 0.8),
        (r * 0.34, h),
        (0.001, h),
    ]
    label = Material(PICTURES[int(rng.integers(len(PICTURES)))], 2 * np.pi * r, roughness=0.6)
    band = lathe([(r + 0.001, h * 0.18), (r + 0.001, h * 0.5)], label, 0.05, 24, picture=True)
    return [lathe(shape, glass, 0.04, 24), band]


def vase(rng: Generator, height: float = 0.0, plant: bool = True) -> Group:
    """Return a thrown vase of a random profile, with flowers in it."""
    height = height or float(rng.uniform(0.14, 0.24))
    s = np.linspace(0, 1, 14)
    waist = 0.16 + 0.16 * np.sin(np.pi * s ** rng.uniform(0.6, 1.5)) + 0.04 * np.sin(2 * np.pi * s + rng.uniform(0, 6))
    radius = waist * height * rng.uniform(0.8, 1.15)
    profile = [(0.0, 0.0), (float(radius[0]), 0.0)] + [
        (float(r), float(z)) for r, z in zip(radius, s * height, strict=True)
    ]
    profile += [(float(radius[-1]) - 0.006, height), (float(radius[-1]) * 0.7, height * 0.8), (0.0, height * 0.78)]
    material = (GLAZED if rng.random() < 0.6 else TERRACOTTA).tinted(*color(rng, 0.6, 1.3))
    group = [lathe(profile, material, 0.03, 28)]
    if plant:
        flower = blossom(rng) if rng.random() < 0.7 else None
        group += moved(bouquet(height * 0.7, height * 1.2, int(rng.integers(8, 14)), rng, flower), 0, 0, height * 0.75)
    return group


def potted_plant(rng: Generator, radius: float = 0.18) -> Group:
    """Return a terracotta pot with a shrub or flowers."""
    h = radius * rng.uniform(1.3, 1.8)
    profile = [
        (0, 0),
        (radius * 0.7, 0),
        (radius * 0.7, 0),
        (radius * 0.93, h * 0.8),
        (radius, h * 0.8),
        (radius, h * 0.8),
        (radius * 1.03, h),
        (radius * 0.92, h),
        (radius * 0.9, h * 0.88),
        (radius * 0.9, h * 0.88),
        (0, h * 0.88),
    ]
    tone = rng.uniform(0.6, 1.1)
    pot = lathe(
        profile, Material("concrete", 0.5, (1.6 * tone, 0.75 * tone, 0.45 * tone), 0.85, relief=0.003), radius * 0.3
    )
    soil = lathe([(radius * 0.9, h * 0.89), (0, h * 0.9)], Material("soil", 0.4, roughness=1.0), radius * 0.3)
    flower = blossom(rng) if rng.random() < 0.5 else None
    if rng.random() < 0.6:
        return [pot, soil, *moved(shrub(radius * rng.uniform(1.0, 1.5), 260, rng, flower), 0, 0, h * 0.85)]
    return [pot, soil, *moved(bouquet(radius * 1.3, radius * rng.uniform(2, 3.2), 14, rng, flower), 0, 0, h * 0.88)]


def fruit(rng: Generator) -> Group:
    """Return an apple-like fruit."""
    noise, r = SpaceNoise(rng), rng.uniform(0.03, 0.045)
    tint = ((0.75, 0.16, 0.07), (0.85, 0.5, 0.08), (0.45, 0.6, 0.12), (0.9, 0.75, 0.15))[int(rng.integers(4))]
    return [displaced(ball(r, WAX.tinted(*tint), r * 0.3, 0.92), lambda p: 0.12 * r * noise(p / r * 0.8))]


def fruit_bowl(rng: Generator) -> Group:
    """Return a bowl with fruit heaped in it."""
    r = rng.uniform(0.13, 0.18)
    profile = [
        (0, 0),
        (r * 0.45, 0),
        (r * 0.45, 0.012),
        (r * 0.8, r * 0.25),
        (r, r * 0.5),
        (r * 0.97, r * 0.5),
        (r * 0.75, r * 0.28),
        (0, r * 0.12),
    ]
    group = [lathe(profile, (GLAZED if rng.random() < 0.5 else WOOD).tinted(*color(rng, 0.6, 1.2)), 0.05, 32)]
    for layer, (count, ring) in enumerate(((5, 0.5), (3, 0.25))):
        for k in range(count):
            angle = 2 * np.pi * (k + 0.4 * rng.random()) / count
            group += moved(fruit(rng), ring * r * np.cos(angle), ring * r * np.sin(angle), r * 0.16 + 0.055 * layer)
    return group


def carton(rng: Generator) -> Group:
    """Return a packet printed with photographs on its sides."""
    w, d, h = rng.uniform(0.08, 0.2), rng.uniform(0.06, 0.14), rng.uniform(0.08, 0.26)
    body = box((w, d, h), CARDBOARD.tinted(*color(rng, 0.3, 0.9)), 0.1, 0.003)
    group, print_ = [body], picture(rng)
    gap = 0.0012
    for angle, width, depth in ((0.0, w, d), (np.pi / 2, d, w), (np.pi, w, d), (-np.pi / 2, d, w)):
        side = quad(
            (-0.44 * width, -depth / 2 - gap, 0.06 * h),
            (0.88 * width, 0, 0),
            (0, 0, 0.88 * h),
            Material(print_.texture, width, roughness=0.35),
            0.1,
            True,
        )
        group.append(side.turned(angle))
    return group


def plate(rng: Generator) -> Group:
    """Return a plate."""
    r = rng.uniform(0.09, 0.13)
    profile = [(0, 0), (r * 0.6, 0), (r * 0.6, 0.003), (r, 0.02), (r - 0.002, 0.023), (r * 0.62, 0.008), (0, 0.008)]
    return [lathe(profile, (CERAMIC if rng.random() < 0.6 else GLAZED).tinted(*color(rng, 0.7, 1.2)), 0.04, 32)]


def teapot(rng: Generator) -> Group:
    """Return a round teapot with spout, handle and lid."""
    r = rng.uniform(0.07, 0.09)
    body = (CERAMIC if rng.random() < 0.5 else STEEL).tinted(*color(rng, 0.6, 1.2))
    angle = np.linspace(-1.2, 1.2, 9)
    handle = np.stack([-r * 0.75 - 0.05 * np.cos(angle), 0 * angle, 0.9 * r + 0.05 * np.sin(angle)], 1)
    spout = np.array([[0.7 * r, 0, 0.5 * r], [1.25 * r, 0, 0.8 * r], [1.5 * r, 0, 1.5 * r], [1.75 * r, 0, 1.7 * r]])
    return [
        ball(r, body, 0.025, 0.9),
        tube(spout, (0.022, 0.016, 0.011, 0.01), body),
        tube(handle, np.full(9, 0.008), body),
        ball(0.016, body, 0.01).moved(0, 0, 1.77 * r),
    ]


def candle_stick(rng: Generator) -> Group:
    """Return a turned candlestick with a candle."""
    h = rng.uniform(0.12, 0.22)
    profile = [
        (0, 0),
        (0.05, 0),
        (0.05, 0.01),
        (0.02, 0.02),
        (0.012, h * 0.4),
        (0.022, h * 0.5),
        (0.012, h * 0.6),
        (0.02, h * 0.95),
        (0.03, h),
        (0, h),
    ]
    return [
        lathe(profile, STEEL.tinted(1.0, 0.8, 0.45), 0.02, 20),
        cylinder(0.011, rng.uniform(0.1, 0.2), Material("paper", 0.2, roughness=0.5), 0.03).moved(0, 0, h),
    ]


def cushion(rng: Generator, size: float = 0.42) -> Group:
    """Return a cushion that lies flat."""
    s = np.linspace(-1, 1, 15)
    x, y = np.meshgrid(s, s)
    bulge = ((1 - x**4) * (1 - y**4)) ** 0.5 * size * 0.2
    pattern = Material(
        ("check", "weave", "carpet")[int(rng.integers(3))], 0.4, color(rng, 0.6, 1.2), 0.95, relief=0.001
    )
    flat = np.stack([x * size / 2 * (1 - 0.06 * (1 - y**2)), y * size / 2 * (1 - 0.06 * (1 - x**2))], -1)
    upper = surface(np.concatenate([flat, (size * 0.2 + bulge)[..., None]], -1), flat, pattern)
    lower = surface(np.concatenate([flat, (size * 0.2 - bulge)[..., None]], -1)[:, ::-1], flat[:, ::-1], pattern)
    return [upper, lower]


TABLEWARE: Sequence[Callable[[Generator], Group]] = (
    mug,
    bottle,
    vase,
    book_stack,
    fruit_bowl,
    carton,
    plate,
    teapot,
    candle_stick,
    fruit,
    mug,
    carton,
)


def arranged(
    radius: float, count: int, rng: Generator, things: Sequence[Callable[[Generator], Group]] = TABLEWARE
) -> Group:
    """Return ``count`` things on a disc of ``radius``, apart from each other, the first near the middle.

    Footprints are measured; a thing that finds no room after forty trials is left away.
    """
    group: Group = []
    taken: list[tuple[float, float, float]] = []
    for k in range(count):
        if k % len(things) == 0:
            order = rng.permutation(len(things))
        thing = turned(things[order[k % len(things)]](rng), rng.uniform(0, 2 * np.pi))
        reach = foot(thing)
        for _ in range(40):
            r, angle = radius * np.sqrt(rng.random()) * (0.4 if k == 0 else 1.0), rng.uniform(0, 2 * np.pi)
            x, y = r * np.cos(angle), r * np.sin(angle)
            if np.hypot(x, y) + 0.7 * reach < radius and all(np.hypot(x - a, y - b) > reach + c for a, b, c in taken):
                taken.append((x, y, reach))
                group += moved(thing, x, y, 0.0)
                break
    return group


def foot(group: Sequence[Mesh]) -> float:
    """Return the radius about the z axis that the lowest 15 cm of ``group`` cover."""
    points = np.concatenate([mesh.vertices for mesh in group])
    low = points[points[:, 2] < 0.15]
    return float(np.hypot(low[:, 0], low[:, 1]).max())
