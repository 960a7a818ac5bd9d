"""Trees, shrubs, hedges, flowers, grass and rocks. Leaves are real geometry: one rhomb each."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.geometry.mesh_model import Array, Color, Group, Material, Mesh, unit
from avs.datasets.embedded.geometry.shapes import ball, box, displaced, tube
from avs.datasets.embedded.materials.noise import SpaceNoise

Generator = np.random.Generator
Floats = npt.NDArray[np.floating]

BARK = Material("bark", 0.5, roughness=0.9, relief=0.01)
FOLIAGE = Material("foliage", 1.1, roughness=0.6, relief=0.04)
LEAF = Material("leaf", 0.12, roughness=0.45, translucency=0.45)
ROCK = Material("stone", 0.8, roughness=0.85, relief=0.012)
GREENS: tuple[Color, ...] = (
    (0.16, 0.3, 0.07),
    (0.24, 0.38, 0.09),
    (0.12, 0.24, 0.09),
    (0.33, 0.38, 0.1),
    (0.2, 0.3, 0.16),
)


def leaves(
    centers: Floats, facing: Floats, size: Floats, material: Material, rng: Generator, droop: float = 0.5
) -> Mesh:
    """Return one rhombic leaf at each of ``centers`` ``[n, 3]``.

    Args:
        centers: bases of the leaves.
        facing: ``[n, 3]`` directions in which the leaves grow.
        size: ``[n]`` lengths in metres.
        material: of the leaves; its ``size`` is the length of the pictured leaf.
        rng: draws each leaf's turn, bend and brightness.
        droop: how much the tips hang down.
    """
    count = len(centers)
    along = unit(facing + 0.7 * rng.normal(size=(count, 3)) + np.array([0, 0, -droop * 0.3]))
    across = unit(np.cross(along, unit(rng.normal(size=(count, 3)) + np.array([0, 0, 1.5]))))
    length = np.asarray(size, np.float32)[:, None]
    tip = centers + along * length + np.array([0, 0, -0.25 * droop]) * length
    middle = centers + along * (0.45 * length)
    width = across * (0.3 * length)
    vertices = np.stack([centers, middle + width, tip, middle - width], axis=1).astype(np.float32)
    normal = unit(np.cross(across, along))
    normal = normal * np.where(normal[:, 2:] < 0, np.float32(-1), np.float32(1))
    square = np.array([[0.5, 1.0], [0.95, 0.5], [0.5, 0.0], [0.05, 0.5]], np.float32) * material.size
    base = 4 * np.arange(count, dtype=np.int32)[:, None]
    triangles = np.concatenate([base + np.array([0, 1, 2], np.int32), base + np.array([0, 2, 3], np.int32)])
    tone = rng.uniform(0.65, 1.25, (count, 1)) * (1 + 0.12 * rng.normal(size=(count, 3)) * np.array([1, 0.3, 0.6]))
    return Mesh(
        vertices.reshape(-1, 3),
        np.repeat(normal, 4, axis=0),
        np.tile(square, (count, 1)),
        triangles,
        material,
        np.repeat(np.clip(tone, 0.2, 1.6), 4, axis=0).astype(np.float32),
        np.repeat(np.arange(count, dtype=np.int32), 4),
    )


def tree(height: float, leaf_count: int, rng: Generator, leaf_size: float = 0.16) -> Group:
    """Return a broad-leaved tree of ``height`` metres with its trunk at the origin."""
    radius = 0.028 * height * rng.uniform(0.8, 1.3)
    lean = rng.normal(size=2) * 0.05 * height
    part = np.linspace(0, 1, 9)[:, None]
    wobble = np.cumsum(rng.normal(size=(9, 2)), axis=0) * 0.012 * height
    trunk = np.concatenate([part**1.5 * lean + wobble * part, part * height * 0.8 - 0.1], axis=1)
    group = [
        tube(trunk, radius * (1.25 - part[:, 0]) ** 1.1 + 0.01 + 0.4 * radius * np.exp(-30 * part[:, 0]), BARK, 10)
    ]
    ends, outward = [], []
    for _ in range(int(rng.integers(9, 14))):
        start = rng.uniform(0.35, 0.97)
        base = np.array([np.interp(start, part[:, 0], trunk[:, k]) for k in range(3)])
        angle = rng.uniform(0, 2 * np.pi)
        reach = height * rng.uniform(0.2, 0.34) * (1.3 - start)
        direction = np.array([np.cos(angle), np.sin(angle), rng.uniform(0.3, 0.9)])
        s = np.linspace(0, 1, 6)[:, None]
        branch = base + s * direction * reach + s**2 * np.array([0, 0, 0.25 * reach])
        branch[1:] += np.cumsum(rng.normal(size=(5, 3)), axis=0) * 0.03 * reach
        group.append(tube(branch, radius * (1.1 - start) * (1 - 0.85 * s[:, 0]) * 0.6 + 0.004, BARK, 6))
        along = rng.uniform(0.45, 1.0, leaf_count // 11 + 1)
        spots = np.stack([np.interp(along, s[:, 0], branch[:, k]) for k in range(3)], 1)
        spread = 0.3 * reach + 0.035 * height
        offsets = rng.normal(size=spots.shape) * spread * np.array([1, 1, 0.7])
        ends.append(spots + offsets)
        outward.append(offsets / spread + np.array([0, 0, -0.2]))
    centers = np.concatenate(ends)
    green = GREENS[int(rng.integers(len(GREENS)))]
    size = rng.uniform(0.7, 1.3, len(centers)) * leaf_size * height / 4
    group.append(leaves(centers, np.concatenate(outward), size, LEAF.tinted(*green), rng))
    return group


def shrub(radius: float, leaf_count: int, rng: Generator, flower: Color | None = None) -> Group:
    """Return a round shrub standing at the origin, with blossoms of the colour ``flower`` if given."""
    noise, squash = SpaceNoise(rng), rng.uniform(0.75, 1.1)
    core = displaced(
        ball(radius * 0.8, FOLIAGE, radius * 0.34, squash), lambda p: 0.3 * radius * noise(p / radius * 1.7)
    )
    direction = unit(rng.normal(size=(leaf_count, 3)))
    center = np.array([0, 0, radius * 0.8 * squash])
    shell = 0.8 + 0.3 * noise(direction * 1.36 + center / radius * 1.7) + 0.18 * rng.random(leaf_count)
    spots = center + direction * np.array([1, 1, squash]) * (radius * shell)[:, None]
    keep = spots[:, 2] > 0.02
    green = GREENS[int(rng.integers(len(GREENS)))]
    size = radius * 0.2 * rng.uniform(0.6, 1.4, keep.sum())
    group = [
        core.clothed(FOLIAGE.tinted(*(np.asarray(green) * 4))),
        leaves(spots[keep], direction[keep], size, LEAF.tinted(*green), rng),
    ]
    if flower is not None:
        chosen = np.flatnonzero(keep & (direction[:, 2] > -0.2))[: leaf_count // 4]
        petals = np.repeat(spots[chosen] + 0.04 * radius * direction[chosen], 5, axis=0)
        facing = np.repeat(direction[chosen], 5, axis=0) + 0.9 * rng.normal(size=(5 * len(chosen), 3))
        group.append(leaves(petals, facing, np.full(len(petals), 0.045 + 0.05 * radius), LEAF.tinted(*flower), rng))
    return group


def hedge(length: float, depth: float, height: float, rng: Generator) -> Group:
    """Return a clipped hedge along x, centred at the origin."""
    noise = SpaceNoise(rng)
    core = displaced(box((length, depth, height), FOLIAGE, 0.3, 0.12), lambda p: 0.1 * noise(p * 1.5))
    count = int(55 * length * (height + depth))
    side = rng.random(count)
    x, z = rng.uniform(-length / 2, length / 2, count), rng.uniform(0.05, height, count)
    y = np.where(side < 0.4, -depth / 2, np.where(side < 0.8, depth / 2, rng.uniform(-depth / 2, depth / 2, count)))
    z = np.where(side < 0.8, z, height)
    facing = np.stack([np.zeros(count), np.where(side < 0.8, np.sign(y), 0), np.where(side < 0.8, 0.3, 1)], 1)
    green = GREENS[int(rng.integers(len(GREENS)))]
    foliage = leaves(np.stack([x, y, z], 1), facing, rng.uniform(0.05, 0.11, count), LEAF.tinted(*green), rng)
    return [core.clothed(FOLIAGE.tinted(*(np.asarray(green) * 4))), foliage]


def tufts(
    spots: Floats, rng: Generator, height: float = 0.12, blades: int = 7, color: Color = (0.2, 0.3, 0.07)
) -> Mesh:
    """Return a tuft of grass at each of ``spots`` ``[n, 3]``."""
    base = np.repeat(spots, blades, axis=0) + rng.normal(size=(len(spots) * blades, 3)) * np.array([0.02, 0.02, 0])
    upward = rng.normal(size=base.shape) * 0.25 + np.array([0, 0, 1.6])
    length = height * rng.uniform(0.5, 1.3, len(base))
    mesh = leaves(base, upward, length, LEAF.tinted(*color), rng, 0.2)
    middle = (mesh.vertices[1::4] + mesh.vertices[3::4]) / 2
    for k in (1, 3):  # blades are narrower than leaves
        mesh.vertices[k::4] = middle + 0.35 * (mesh.vertices[k::4] - middle)
    return mesh


def bouquet(radius: float, height: float, count: int, rng: Generator, flower: Color | None = None) -> Group:
    """Return stems with leaves, and blossoms if ``flower`` is given, that spread from the origin up to ``height``."""
    group: Group = []
    tips, directions = [], []
    for _ in range(count):
        angle, reach = rng.uniform(0, 2 * np.pi), radius * np.sqrt(rng.random())
        s = np.linspace(0, 1, 5)[:, None]
        top = np.array([reach * np.cos(angle), reach * np.sin(angle), height * rng.uniform(0.65, 1)])
        stem = s * np.array([0, 0, 1.0]) * top[2] + s**2 * np.array([top[0], top[1], 0])
        group.append(tube(stem, np.full(5, 0.004), LEAF.tinted(0.15, 0.25, 0.08), 5))
        spots = stem[1:].repeat(4, axis=0) + rng.normal(size=(16, 3)) * 0.04 * height
        tips.append(spots)
        directions.append(unit(rng.normal(size=spots.shape) + np.array([top[0], top[1], 0]) / radius))
        if flower is not None:
            petals = np.repeat(stem[-1:], 9, axis=0)
            group.append(
                leaves(
                    petals,
                    rng.normal(size=(9, 3)) + np.array([0, 0, 0.8]),
                    np.full(9, 0.03 + 0.03 * height),
                    LEAF.tinted(*flower),
                    rng,
                )
            )
    green = GREENS[int(rng.integers(len(GREENS)))]
    centers = np.concatenate(tips)
    group.append(
        leaves(
            centers,
            np.concatenate(directions),
            rng.uniform(0.5, 1.1, len(centers)) * (0.035 + 0.1 * height),
            LEAF.tinted(*green),
            rng,
        )
    )
    return group


def creeper(rng: Generator, width: float, height: float) -> Group:
    """Return ivy on a wall that faces -y at y = 0, spread from the origin upwards."""
    group: Group = []
    centers = []
    for _ in range(9):
        s = np.linspace(0, 1, 14)
        x = np.cumsum(rng.normal(size=14)) * 0.06 * width + rng.normal() * 0.22 * width * s
        stem = np.stack([x, np.full(14, -0.02), s * height * rng.uniform(0.5, 1)], 1)
        group.append(tube(stem, np.linspace(0.018, 0.005, 14), BARK, 5))
        spots = stem[rng.integers(2, 14, 150)] + rng.normal(size=(150, 3)) * np.array([0.13, 0.0, 0.13])
        centers.append(spots - np.array([0, 0.05, 0]) * rng.random((150, 1)))
    spots = np.concatenate(centers)
    spots = spots[spots[:, 2] > 0.05]
    facing = np.tile([0.0, -0.9, -0.2], (len(spots), 1))
    green = GREENS[int(rng.integers(len(GREENS)))]
    group.append(leaves(spots, facing, rng.uniform(0.07, 0.15, len(spots)), LEAF.tinted(*green), rng))
    return group


def rock(radius: float, rng: Generator) -> Mesh:
    """Return a boulder that is sunk a little into the ground at the origin."""
    noise = SpaceNoise(rng)
    shape = displaced(ball(radius, ROCK, radius * 0.25, 0.7), lambda p: 0.55 * radius * noise(p / radius * 1.1, 4))
    squeeze = rng.uniform(0.7, 1.2, 2)
    tone = rng.uniform(0.6, 1.1)
    return (
        shape.scaled(squeeze[0], squeeze[1], 1.0)
        .moved(0, 0, -0.15 * radius)
        .clothed(ROCK.tinted(tone, tone, tone * 0.97))
    )


def scatter(count: int, inner: float, outer: float, rng: Generator) -> Array:
    """Return ``[count, 2]`` points spread evenly over a ring about the origin."""
    radius = np.sqrt(rng.uniform(inner**2, outer**2, count))
    angle = rng.uniform(0, 2 * np.pi, count)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1).astype(np.float32)
