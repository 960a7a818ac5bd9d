"""Statues: blended capsules turned to a surface, on a moulded plinth."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from skimage.measure import marching_cubes

from avs.datasets.embedded.geometry.mesh_model import Group, Material, Mesh, unit
from avs.datasets.embedded.geometry.shapes import box
from avs.datasets.embedded.materials.noise import SpaceNoise

Generator = np.random.Generator
Floats = npt.NDArray[np.floating]


def box_mapped(vertices: Floats, normals: Floats, triangles: npt.NDArray[np.integer], material: Material) -> Mesh:
    """Return a mesh with texture coordinates along the two axes that each triangle faces least; corners are split."""
    corners = vertices[triangles]
    axis = np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])).argmax(axis=1)
    key, inverse = np.unique(triangles * 3 + axis[:, None], return_inverse=True)
    vertex, side = key // 3, key % 3
    points = vertices[vertex]
    along = np.array([[1, 2], [0, 2], [0, 1]])[side]
    coordinates = np.take_along_axis(points, along, axis=1) * np.array([1, -1])
    site = np.unique(vertex, return_inverse=True)[1].ravel()
    return Mesh(
        points.astype(np.float32),
        unit(normals[vertex]),
        coordinates.astype(np.float32),
        inverse.reshape(-1, 3).astype(np.int32),
        material,
        site=site.astype(np.int32),
    )


def _capsules(height: float, rng: Generator) -> list[tuple[Floats, Floats, float, float]]:
    """Return the limbs of a standing figure of one metre as (start, end, radius at start, radius at end)."""
    lean, turn = rng.normal() * 0.03, rng.choice([-1.0, 1.0])
    hip, chest, neck = np.array([lean, 0, 0.5]), np.array([-lean, 0.01, 0.72]), np.array([-lean, 0, 0.84])
    head = neck + np.array([0.01 * turn, -0.015, 0.075])
    limbs = [
        (hip, chest, 0.095, 0.105),
        (chest, neck, 0.085, 0.04),
        (head - np.array([0, 0, 0.015]), head + np.array([0, 0, 0.02]), 0.052, 0.058),
        (head + np.array([0, -0.05, -0.005]), head + np.array([0, -0.062, -0.01]), 0.014, 0.016),
    ]
    for side in (-1.0, 1.0):
        step = 0.07 * side * turn
        knee = np.array([0.07 * side + lean, -0.05 * step / 0.07, 0.27])
        limbs += [
            (hip + np.array([0.06 * side, 0, -0.02]), knee, 0.075, 0.05),
            (knee, np.array([0.08 * side, step * 0.6, 0.03]), 0.05, 0.035),
            (np.array([0.08 * side, step * 0.6, 0.03]), np.array([0.09 * side, step * 0.6 - 0.09, 0.02]), 0.033, 0.025),
        ]
        shoulder = chest + np.array([0.12 * side, 0, 0.06])
        raised = rng.uniform(-0.6, 1.0)
        elbow = shoulder + 0.17 * unit(np.array([side * rng.uniform(0.5, 1.0), -0.3, -0.8 + raised]))
        hand = elbow + 0.16 * unit(np.array([-0.4 * side, -0.8, rng.uniform(-0.4, 0.9)]))
        limbs += [
            (shoulder, elbow, 0.048, 0.036),
            (elbow, hand, 0.036, 0.024),
            (hand, hand + 0.03 * unit(hand - elbow), 0.03, 0.02),
        ]
    # A robe from the hip to the ground hides most of the legs.
    limbs.append((hip, np.array([0.0, 0.03, 0.1]), 0.1, 0.15))
    return limbs


def statue(rng: Generator, height: float) -> Group:
    """Return a robed figure of ``height`` metres, of stone or bronze, facing -y."""
    axes = [
        np.linspace(low, high, count) for low, high, count in ((-0.38, 0.38, 44), (-0.34, 0.34, 40), (-0.04, 1.1, 66))
    ]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    total = np.zeros(len(grid))
    for start, end, first, last in _capsules(height, rng):
        way = end - start
        part = np.clip((grid - start) @ way / (way @ way), 0, 1)
        distance = np.linalg.norm(grid - start - part[:, None] * way, axis=1) - (first + (last - first) * part)
        total += np.exp(-distance / 0.016)
    angle = np.arctan2(grid[:, 1], grid[:, 0])
    folds = 0.012 * np.sin(11 * angle + 5 * np.sin(7 * grid[:, 2])) * np.clip((0.62 - grid[:, 2]) * 4, 0, 1)
    field = -0.016 * np.log(np.maximum(total, 1e-12)) + folds + 0.006 * SpaceNoise(rng)(grid * 14, 3)
    field = np.maximum(field, 0.0 - grid[:, 2])
    shape = tuple(len(axis) for axis in axes)
    spacing = tuple(float(axis[1] - axis[0]) for axis in axes)
    vertices, triangles, normals, _ = marching_cubes(  # type: ignore[no-untyped-call]
        field.reshape(shape), 0.0, spacing=spacing, gradient_direction="ascent"
    )
    vertices = (vertices + [axis[0] for axis in axes]) * height
    tone = rng.uniform(0.8, 1.25)
    stone = Material("stone", 0.9, (tone, tone * 0.97, tone * 0.9), 0.6, relief=0.004)
    bronze = Material("metal", 0.6, (0.32, 0.36, 0.26), 0.42, 0.35, 0.002)
    marble = Material("marble", 0.8, (1.1, 1.06, 1.0), 0.35, 0.045)
    material = (stone, bronze, marble)[int(rng.integers(3))]
    return [box_mapped(vertices, -normals, triangles, material)]


def plinth(rng: Generator) -> Group:
    """Return a moulded square plinth."""
    material = Material(("stone", "concrete", "marble")[int(rng.integers(3))], 1.0, roughness=0.75, relief=0.004)
    width, height = rng.uniform(0.5, 0.65), rng.uniform(0.5, 0.8)
    steps = ((1.35, 0.08), (1.2, 0.05), (1.0, height), (1.12, 0.04), (1.25, 0.07))
    group: list[Mesh] = []
    z = 0.0
    for factor, rise in steps:
        group.append(box((width * factor, width * factor, rise), material, 0.08, 0.012).moved(0, 0, z).shifted(rng))
        z += rise - 0.002
    return group
