"""Books: single, stacked, and in rows."""

from __future__ import annotations

import numpy as np

from avs.datasets.embedded.geometry.mesh_model import Group, moved, turned
from avs.datasets.embedded.geometry.shapes import box, quad
from avs.datasets.embedded.materials.palette import CLOTH, PAGES, color, picture

Generator = np.random.Generator


def book(rng: Generator) -> Group:
    """Return a book that lies flat, its cover a photograph or cloth."""
    w, d, h = rng.uniform(0.13, 0.2), rng.uniform(0.18, 0.27), rng.uniform(0.015, 0.045)
    cover = CLOTH.tinted(*color(rng))
    t = 0.003
    group = [
        box((w, d, t), cover, 0.2, 0),
        box((w - 0.008, d - 0.01, h - 2 * t), PAGES, 0.2, 0).moved(0.002, 0, t),
        box((w, d, t), cover, 0.2, 0).moved(0, 0, h - t),
        box((t, d, h), cover, 0.2, 0).moved(-w / 2, 0, 0),
    ]
    if rng.random() < 0.7:
        margin = 0.1 * w
        group.append(
            quad(
                (-w / 2 + margin, -d / 2 + margin, h + 0.0008),
                (w - 2 * margin, 0, 0),
                (0, d - 2 * margin, 0),
                picture(rng, w),
                0.1,
                True,
            )
        )
    return group


def book_stack(rng: Generator) -> Group:
    """Return two to five books on each other."""
    group: Group = []
    top = 0.0
    for _ in range(int(rng.integers(2, 6))):
        one = turned(book(rng), rng.normal() * 0.35)
        group += moved(one, rng.normal() * 0.01, rng.normal() * 0.01, top)
        top += float(max(mesh.vertices[:, 2].max() for mesh in one)) + 0.0005
    return group


def book_row(length: float, rng: Generator) -> Group:
    """Return upright books side by side along x, their spines towards -y, over ``length`` metres."""
    group: Group = []
    x = 0.0
    while x < length - 0.05:
        w, h, d = rng.uniform(0.018, 0.05), rng.uniform(0.17, 0.27), rng.uniform(0.12, 0.17)
        if rng.random() < 0.08:
            x += rng.uniform(0.05, 0.15)
            continue
        one = box((w, d, h), CLOTH.tinted(*color(rng)), 0.3, 0).moved(w / 2, d / 2, 0)
        group.append(one.turned(rng.normal() * 0.02, "y").moved(x - length / 2, 0, 0.002))
        x += w + 0.002
    return group
