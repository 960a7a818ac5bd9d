"""Textures of what grows and lies about outdoors."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from avs.datasets.embedded.materials.library_photographs import grey, tileable
from avs.datasets.embedded.materials.noise import cellular, fractal_noise
from avs.datasets.embedded.materials.patterns import (
    Generator,
    Texture,
    coordinates,
    per_piece,
    ramp,
    smoothstep,
    texture,
)


def _grass(size: int, rng: Generator) -> Texture:
    blades = tileable(grey("grass", size))
    patch = fractal_noise(size, 4, rng, 4)
    fresh = ramp(blades, (0.012, 0.022, 0.006), (0.07, 0.12, 0.025), (0.25, 0.33, 0.1))
    dry = ramp(blades, (0.03, 0.026, 0.01), (0.17, 0.15, 0.06), (0.42, 0.38, 0.19))
    weight = (smoothstep(0.45, 0.9, patch) * 0.7)[..., None]
    return texture(fresh * (1 - weight) + dry * weight, blades, blades * 0.3)


def _gravel(size: int, rng: Generator) -> Texture:
    stones = tileable(grey("gravel", size))
    hue = fractal_noise(size, 12, rng, 3)[..., None]
    cold = ramp(stones, (0.03, 0.03, 0.03), (0.2, 0.2, 0.2), (0.55, 0.55, 0.55))
    warm = ramp(stones, (0.04, 0.03, 0.02), (0.27, 0.21, 0.16), (0.6, 0.53, 0.44))
    return texture(cold * (1 - hue) + warm * hue, stones, stones * 0.4)


def _soil(size: int, rng: Generator) -> Texture:
    crumbs = 0.5 * fractal_noise(size, 24, rng, 4, 0.8) + 0.5 * tileable(grey("gravel", size))
    leaves = smoothstep(0.62, 0.7, fractal_noise(size, 20, rng, 2))[..., None]
    ground = ramp(crumbs, (0.02, 0.014, 0.01), (0.1, 0.07, 0.045), (0.25, 0.19, 0.13))
    return texture(
        ground * (1 - leaves) + np.array([0.24, 0.15, 0.06], np.float32) * leaves * (0.5 + crumbs[..., None]), crumbs
    )


def _bark(size: int, rng: Generator) -> Texture:
    ridges = 1 - np.abs(2 * fractal_noise(size, (3, 12), rng, 4, 0.6) - 1)
    grain = fractal_noise(size, 32, rng, 3)
    tone = np.clip(1.3 * ridges - 0.4 + 0.4 * (grain - 0.5), 0, 1)
    moss = (smoothstep(0.55, 0.8, fractal_noise(size, 3, rng, 4)) * 0.5)[..., None]
    color = ramp(tone, (0.2, 0.16, 0.12), (0.11, 0.08, 0.055), (0.025, 0.018, 0.012))
    return texture(color * (1 - moss) + np.array([0.09, 0.12, 0.04], np.float32) * moss, 1 - tone)


def _leaf(size: int, rng: Generator) -> Texture:
    y, x = coordinates(size)
    rib = np.abs(x - 0.5)
    veins = np.minimum(rib * 6, np.abs((y * 8 + rib * 6) % 1 - 0.5) * 4)
    tone = np.clip(
        0.45 + 0.5 * fractal_noise(size, 6, rng, 4) - 0.35 * smoothstep(0.5, 0.0, veins.astype(np.float32)), 0, 1
    )
    return texture(ramp(tone, (0.12, 0.2, 0.06), (0.5, 0.6, 0.3), (0.8, 0.85, 0.55)), tone, 0.6 + 0.4 * tone)


def _foliage(size: int, rng: Generator) -> Texture:
    distance, border, cell = cellular(size, 22, rng)
    inside = smoothstep(0.0, 0.25, border) * (1 - 0.7 * distance)
    tone = np.clip(inside * (0.35 + 0.8 * per_piece(cell, rng)), 0, 1)
    gap = 0.35 + 0.65 * smoothstep(0.3, 0.6, fractal_noise(size, 8, rng, 4))
    color = ramp(tone, (0.006, 0.012, 0.004), (0.05, 0.085, 0.022), (0.2, 0.27, 0.08))
    return texture(color * gap[..., None], inside, 0.6 * inside)


def _stone(size: int, rng: Generator) -> Texture:
    coarse, grain = fractal_noise(size, 3, rng, 6, 0.65), tileable(grey("moon", size))
    lichen = smoothstep(0.6, 0.75, fractal_noise(size, 7, rng, 5, 0.6))[..., None]
    color = ramp(np.clip(0.6 * coarse + 0.4 * grain, 0, 1), (0.12, 0.11, 0.1), (0.36, 0.34, 0.31), (0.6, 0.57, 0.52))
    return texture(
        color * (1 - 0.6 * lichen) + np.array([0.3, 0.29, 0.16], np.float32) * 0.6 * lichen,
        0.6 * coarse + 0.4 * grain,
        0.3 * grain,
    )


def _cobbles(size: int, rng: Generator) -> Texture:
    distance, border, cell = cellular(size, 9, rng, 0.55)
    inside = smoothstep(0.04, 0.2, border)
    grain = fractal_noise(size, 32, rng, 4, 0.7)
    tone = np.clip(0.2 + 0.5 * per_piece(cell, rng) + 0.5 * (grain - 0.5), 0, 1)
    color = ramp(tone, (0.09, 0.09, 0.1), (0.25, 0.24, 0.23), (0.42, 0.38, 0.33))
    joint = ramp(grain, (0.03, 0.035, 0.02), (0.12, 0.1, 0.07))
    height = inside * (1 - 0.4 * distance)
    return texture(color * inside[..., None] + joint * (1 - inside[..., None]), height, inside * 0.6)


def _paving(size: int, rng: Generator) -> Texture:
    stone = tileable(grey("brick", size).T.copy())
    wear = fractal_noise(size, 3, rng, 4)
    color = ramp(stone, (0.08, 0.07, 0.06), (0.3, 0.25, 0.21), (0.52, 0.46, 0.4)) * (0.7 + 0.5 * wear[..., None])
    return texture(color, stone, stone * 0.5)


def _fruit(size: int, rng: Generator) -> Texture:
    speckle = fractal_noise(size, 40, rng, 3, 0.8)
    blush = fractal_noise(size, 2, rng, 3)
    tone = np.clip(0.6 * blush + 0.4 * speckle, 0, 1)
    return texture(ramp(tone, (0.75, 0.42, 0.3), (0.9, 0.85, 0.7)), speckle)


PROCEDURES: dict[str, Callable[[int, Generator], Texture]] = {
    "bark": _bark,
    "cobbles": _cobbles,
    "foliage": _foliage,
    "fruit": _fruit,
    "grass": _grass,
    "gravel": _gravel,
    "leaf": _leaf,
    "paving": _paving,
    "soil": _soil,
    "stone": _stone,
}
