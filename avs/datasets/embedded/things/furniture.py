"""Furniture. Each piece stands at the origin with its front towards -y."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avs.datasets.embedded.geometry.mesh_model import Color, Group, Material, Mesh, moved
from avs.datasets.embedded.geometry.shapes import box, cylinder, lathe, quad, tube
from avs.datasets.embedded.materials.palette import CERAMIC, CLOTH, STEEL, WOOD, color, picture
from avs.datasets.embedded.things.books import book_row
from avs.datasets.embedded.things.props import arranged, cushion, mug, vase

Generator = np.random.Generator


def wood(rng: Generator) -> Material:
    """Return wood of a random tone."""
    tone = rng.uniform(0.35, 1.25)
    return WOOD.tinted(tone * rng.uniform(0.9, 1.1), tone, tone * rng.uniform(0.85, 1.1))


def _legs(width: float, depth: float, height: float, radius: float, material: Material, square: bool) -> Group:
    leg = (
        box((2 * radius, 2 * radius, height), material, 0.15, 0.004)
        if square
        else cylinder(radius, height, material, 0.1)
    )
    return [
        leg.moved(x * (width / 2 - 1.5 * radius), y * (depth / 2 - 1.5 * radius), 0) for x in (-1, 1) for y in (-1, 1)
    ]


def round_table(radius: float, height: float, rng: Generator) -> Group:
    """Return a round table on three curved feet."""
    material = wood(rng)
    edge = 0.012
    top = lathe(
        [
            (0, height - 0.045),
            (radius - 0.03, height - 0.045),
            (radius, height - 0.03),
            (radius, height - edge),
            (radius - edge, height),
            (0, height),
        ],
        material,
        0.05,
        64,
    )
    s = np.linspace(0, 1, 9)
    column = lathe(
        [(0.05, 0.1), (0.08, 0.16), (0.05, 0.28), (0.035, 0.45), (0.06, height - 0.12), (0.1, height - 0.05)],
        material,
        0.05,
        20,
    )
    # The top's texture lies flat, as its boards do; wrapped around it would meet in the middle.
    flat = replace(top, coordinates=np.ascontiguousarray(top.vertices[:, :2]))
    group = [flat.turned(rng.uniform(0, 6)), column]
    for k in range(3):
        foot = np.stack([0.03 + 0.6 * radius * s, 0 * s, 0.22 * (1 - s) ** 2 + 0.025], 1)
        group.append(tube(foot, np.linspace(0.035, 0.024, 9), material, 10).turned(2 * np.pi * k / 3))
    return group


def table(width: float, depth: float, height: float, rng: Generator) -> Group:
    """Return a table with four legs and an apron."""
    material, square = wood(rng), bool(rng.random() < 0.6)
    group = [box((width, depth, 0.035), material, 0.06, 0.006).moved(0, 0, height - 0.035).shifted(rng)]
    group += _legs(width, depth, height - 0.03, 0.032, material, square)
    for sign in (-1, 1):
        group.append(
            box((width - 0.14, 0.02, 0.08), material, 0.2, 0.003).moved(0, sign * (depth / 2 - 0.05), height - 0.115)
        )
        group.append(
            box((0.02, depth - 0.14, 0.08), material, 0.2, 0.003).moved(sign * (width / 2 - 0.05), 0, height - 0.115)
        )
    return group


def trestle(length: float, rng: Generator) -> Group:
    """Return a garden bench of boards with a back."""
    material, group = wood(rng), []
    for k in range(4):
        group.append(box((length, 0.1, 0.03), material, 0.15, 0.006).moved(0, -0.18 + 0.115 * k, 0.43).shifted(rng))
    for k in range(3):
        group.append(
            box((length, 0.025, 0.1), material, 0.15, 0.006).moved(0, 0.22 + 0.02 * k, 0.55 + 0.14 * k).shifted(rng)
        )
    for x in (-1, 1):
        group.append(box((0.06, 0.06, 0.43), material, 0.15, 0.005).moved(x * (length / 2 - 0.12), -0.16, 0))
        group.append(
            box((0.06, 0.06, 0.95), material, 0.15, 0.005).turned(-0.1, "x").moved(x * (length / 2 - 0.12), 0.19, 0)
        )
        group.append(box((0.05, 0.44, 0.04), material, 0.15, 0.005).moved(x * (length / 2 - 0.12), 0, 0.39))
    return group


def chair(rng: Generator) -> Group:
    """Return a wooden chair with a slatted back, sometimes with a seat cushion."""
    material, size, seat = wood(rng), 0.43, 0.45
    group = [
        box((size, size, 0.03), material, 0.1, 0.008).moved(0, 0, seat - 0.03),
        *_legs(size, size, seat - 0.02, 0.018, material, False),
    ]
    for x in (-1, 1):
        group.append(
            box((0.035, 0.035, 0.5), material, 0.15, 0.005)
            .turned(-0.12, "x")
            .moved(x * (size / 2 - 0.03), size / 2 - 0.03, seat - 0.02)
        )
    for k in range(3):
        z = 0.14 + 0.13 * k
        group.append(
            box((size - 0.08, 0.015, 0.06), material, 0.15, 0.004)
            .turned(-0.12, "x")
            .moved(0, size / 2 - 0.03 + 0.12 * z, seat + z)
        )
    if rng.random() < 0.5:
        group += moved([m.scaled(0.92, 0.92, 0.45) for m in cushion(rng)], 0, 0, seat - 0.005)
    return group


def bookcase(width: float, height: float, rng: Generator) -> Group:
    """Return a bookcase against y = 0, filled with books and things; it reaches to y = -0.3."""
    material, depth, t = wood(rng), 0.3, 0.022
    group: Group = [
        box((t, depth, height), material, 0.25, 0.002).moved(x * (width / 2 - t / 2), -depth / 2, 0).shifted(rng)
        for x in (-1, 1)
    ]
    group.append(box((width - 2 * t, 0.01, height), material, 0.25, 0.001).moved(0, -0.006, 0))
    levels = int(height / 0.36)
    for k in range(levels + 1):
        z = 0.06 + k * (height - 0.06 - t) / levels
        group.append(box((width - 2 * t, depth - 0.01, t), material, 0.15, 0.002).moved(0, -depth / 2, z).shifted(rng))
        if k == levels:
            break
        filled = rng.uniform(0.4, 1.0) * (width - 2 * t)
        group += moved(book_row(filled, rng), (filled - width) / 2 + t, -depth + 0.05, z + t)
        if width - filled > 0.3:
            group += moved(arranged(0.1, 1, rng, (mug, vase)), width / 2 - 0.16, -depth / 2, z + t)
    return group


def cabinet(width: float, height: float, rng: Generator) -> Group:
    """Return a chest of drawers against y = 0."""
    material, depth = wood(rng), 0.42
    group = [box((width, depth, height), material, 0.1, 0.006).moved(0, -depth / 2, 0)]
    rows, columns = max(2, int(height / 0.24)), 1 if width < 0.7 else 2
    face = material.tinted(*(0.92 * np.asarray(material.tint)))
    for row in range(rows):
        for column in range(columns):
            w, h = width / columns - 0.04, (height - 0.08) / rows - 0.02
            x, z = (column + 0.5) * width / columns - width / 2, 0.05 + row * (height - 0.08) / rows
            group.append(box((w, 0.02, h), face, 0.15, 0.006).moved(x, -depth - 0.008, z).shifted(rng))
            group.append(box((0.1, 0.02, 0.014), STEEL, 0.1, 0.004).moved(x, -depth - 0.03, z + h / 2))
    return group


def sofa(width: float, rng: Generator) -> Group:
    """Return an upholstered sofa with cushions, its back at y = 0."""
    fabric = CLOTH.tinted(*color(rng, 0.25, 0.9))
    group = [
        box((width, 0.85, 0.24), fabric, 0.12, 0.04).moved(0, -0.43, 0.1),
        box((width, 0.22, 0.78), fabric, 0.12, 0.07).moved(0, -0.11, 0.08),
        *(box((0.2, 0.86, 0.58), fabric, 0.12, 0.07).moved(x * (width / 2 - 0.1), -0.43, 0.05) for x in (-1, 1)),
    ]
    seats = max(1, round(width / 0.75))
    inner = (width - 0.42) / seats
    for k in range(seats):
        x = (k + 0.5) * inner - inner * seats / 2
        group.append(box((inner - 0.01, 0.6, 0.16), fabric, 0.1, 0.05).moved(x, -0.52, 0.33).shifted(rng))
        group.append(
            box((inner - 0.03, 0.17, 0.42), fabric, 0.1, 0.07).turned(-0.18, "x").moved(x, -0.3, 0.46).shifted(rng)
        )
        if rng.random() < 0.7:
            pillow = [m.turned(np.pi / 2 - 0.35, "x") for m in cushion(rng)]
            group += moved(pillow, x + rng.normal() * 0.08, -0.45, 0.66)
    return group


def bed(width: float, rng: Generator) -> Group:
    """Return a bed with its head at y = 0."""
    frame = wood(rng)
    sheet = Material(("check", "weave", "carpet")[int(rng.integers(3))], 0.7, color(rng, 0.5, 1.1), 0.95)
    group = [
        box((width + 0.1, 2.05, 0.25), frame, 0.2, 0.01).moved(0, -1.05, 0.1),
        box((width + 0.1, 0.06, 1.0), frame, 0.15, 0.02).moved(0, -0.03, 0),
        box((width, 1.95, 0.2), CLOTH, 0.12, 0.06).moved(0, -1.05, 0.32),
        box((width + 0.03, 1.35, 0.14), sheet, 0.1, 0.06).moved(0, -1.36, 0.42),
    ]
    for x in (-0.25, 0.25) if width > 1.2 else (0.0,):
        group += moved([m.scaled(1.4, 0.95, 1.0) for m in cushion(rng)], x * width, -0.3, 0.46)
    return group


def floor_lamp(rng: Generator, height: float = 1.55) -> Group:
    """Return a lamp on a stand; its shade glows."""
    glow: Color = (1.6, 1.25, 0.8)
    shade = Material("weave", 0.2, (0.9, 0.8, 0.6), 0.9, emission=glow)
    r = rng.uniform(0.16, 0.22)
    return [
        cylinder(0.14, 0.02, STEEL),
        cylinder(0.012, height, STEEL, 0.2),
        lathe([(r, height - 0.22), (r * 0.7, height + 0.05)], shade, 0.06, 24),
        lathe([(r * 0.69, height + 0.05), (r * 0.99, height - 0.22)], shade, 0.06, 24),
    ]


def pendant(ceiling: float, height: float, rng: Generator) -> Group:
    """Return a lamp that hangs from the ceiling with its lower rim at ``height``."""
    material = STEEL.tinted(*color(rng, 0.3, 1.0))
    bulb = Material("marble", 0.2, roughness=0.8, emission=(6.0, 5.0, 3.6))
    profile = [(0.2, height), (0.16, height + 0.1), (0.05, height + 0.17), (0.02, height + 0.22)]
    inside = CERAMIC.tinted(1.0, 0.95, 0.85)
    return [
        lathe(profile, material, 0.05, 28),
        lathe([(r - 0.004, z) for r, z in profile[::-1]], inside, 0.05, 28),
        tube(
            np.array([[0, 0, height + 0.2], [0, 0, (height + ceiling) / 2], [0, 0, ceiling]]),
            np.full(3, 0.006),
            STEEL.tinted(0.1, 0.1, 0.1),
        ),
        lathe(
            [(0.001, height + 0.06), (0.03, height + 0.075), (0.03, height + 0.1), (0.001, height + 0.12)],
            bulb,
            0.03,
            12,
        ),
    ]


def rug(width: float, depth: float, rng: Generator) -> Group:
    """Return a rug, patterned once over its whole size."""
    mesh = quad(
        (-width / 2, -depth / 2, 0.012),
        (width, 0, 0),
        (0, depth, 0),
        Material("carpet", width, roughness=1.0, relief=0.004),
        0.12,
        True,
    )
    return [mesh, box((width, depth, 0.01), CLOTH.tinted(*color(rng, 0.2, 0.6)), 0.4, 0.002)]


def framed_picture(width: float, height: float, rng: Generator) -> Group:
    """Return a framed photograph on the wall y = 0, centred at the origin, facing -y."""
    frame, t = wood(rng), 0.03
    group: list[Mesh] = [
        quad((-width / 2, -0.012, -height / 2), (width, 0, 0), (0, 0, height), picture(rng, width), 0.15, True)
    ]
    for z in (-1, 1):
        group.append(box((width + 2 * t, 0.03, t), frame, 0.2, 0.004).moved(0, -0.016, z * (height + t) / 2 - t / 2))
    for x in (-1, 1):
        group.append(box((t, 0.03, height), frame, 0.2, 0.004).moved(x * (width + t) / 2, -0.016, -height / 2))
    return group


def kitchenette(width: float, rng: Generator) -> Group:
    """Return a kitchen counter against y = 0 with cupboards above it, tiles between, and things on it."""
    material, depth, height = wood(rng), 0.58, 0.88
    stone = Material("marble", 0.7, (0.8, 0.78, 0.75) if rng.random() < 0.5 else (0.2, 0.2, 0.21), 0.15, 0.05)
    count = max(2, round(width / 0.55))
    step = width / count
    group: Group = [
        box((width, depth - 0.04, height - 0.1), material, 0.15, 0.004).moved(0, -depth / 2, 0.1),
        box((width + 0.02, depth + 0.03, 0.035), stone, 0.08, 0.006).moved(0, -depth / 2 - 0.01, height),
        quad(
            (-width / 2, -0.005, height),
            (width, 0, 0),
            (0, 0, 0.55),
            Material("tiles", 0.6, roughness=0.18, relief=0.002),
            0.12,
        ),
        box((width, 0.32, 0.7), material, 0.15, 0.006).moved(0, -0.16, height + 0.55),
    ]
    for k in range(count):
        x = (k + 0.5) * step - width / 2
        group.append(
            box((step - 0.015, 0.02, height - 0.14), material, 0.15, 0.005).moved(x, -depth + 0.01, 0.12).shifted(rng)
        )
        group.append(box((step - 0.015, 0.02, 0.68), material, 0.15, 0.005).moved(x, -0.33, height + 0.56).shifted(rng))
        for y, z in ((-depth - 0.012, height - 0.12), (-0.352, height + 0.62)):
            group.append(box((0.11, 0.018, 0.012), STEEL, 0.1, 0.004).moved(x, y, z))
    for x in np.arange(-width / 2 + 0.25, width / 2 - 0.2, 0.5):
        group += moved(arranged(0.2, 3, rng), float(x), -0.3, height + 0.036)
    return group
