"""Textures of building materials: masonry, stone, wood, metal."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from avs.datasets.embedded.materials.library_photographs import grey, tileable
from avs.datasets.embedded.materials.noise import cellular, fractal_noise
from avs.datasets.embedded.materials.patterns import (
    Generator,
    Texture,
    coordinates,
    courses,
    per_piece,
    ramp,
    smoothstep,
    texture,
)


def _bricks(size: int, rng: Generator) -> Texture:
    inside, piece = courses(size, 12, 4, 0.012, 0.5)
    grain = tileable(grey("moon", size)) * 0.4 + fractal_noise(size, 16, rng, 5, 0.7) * 0.6
    tone = np.clip(0.25 + 0.5 * per_piece(piece, rng) + 0.5 * (grain - 0.5), 0, 1)
    clay = ramp(tone, (0.11, 0.045, 0.03), (0.30, 0.12, 0.075), (0.46, 0.24, 0.15))
    mortar = ramp(grain, (0.28, 0.26, 0.23), (0.5, 0.47, 0.42))
    soot = 0.75 + 0.25 * fractal_noise(size, 3, rng, 3)
    mask = inside[..., None]
    return texture((clay * mask + mortar * (1 - mask)) * soot[..., None], inside * 0.8 + grain * 0.2, 0.3 * inside)


def _rubble(size: int, rng: Generator) -> Texture:
    _, border, cell = cellular(size, 6, rng, 0.3)
    inside = smoothstep(0.03, 0.12, border)
    grain = 0.6 * fractal_noise(size, 16, rng, 5, 0.7) + 0.4 * tileable(grey("moon", size))
    tone = np.clip(0.3 * grain + 0.7 * per_piece(cell, rng), 0, 1)
    stone = ramp(tone, (0.16, 0.13, 0.1), (0.33, 0.29, 0.23), (0.5, 0.46, 0.39)) * (0.55 + 0.8 * grain[..., None])
    mortar = ramp(grain, (0.2, 0.18, 0.15), (0.4, 0.37, 0.32))
    mask = inside[..., None]
    return texture(stone * mask + mortar * (1 - mask), inside * (0.6 + 0.4 * grain), 0.2 * inside)


def _plaster(size: int, rng: Generator) -> Texture:
    coarse, fine = fractal_noise(size, 3, rng, 6, 0.6), fractal_noise(size, 48, rng, 3, 0.8)
    stain = smoothstep(0.5, 0.95, fractal_noise(size, (2, 6), rng, 5, 0.6))
    tone = np.clip(0.66 + 0.24 * (coarse - 0.5) + 0.22 * (fine - 0.5) - 0.14 * stain, 0, 1)
    return texture(ramp(tone, (0.1, 0.095, 0.085), (0.8, 0.78, 0.74)), 0.5 * coarse + 0.5 * fine, 0.3 * fine)


def _concrete(size: int, rng: Generator) -> Texture:
    coarse = fractal_noise(size, 4, rng, 6, 0.7)
    grain = tileable(grey("moon", size))
    pores = smoothstep(0.78, 0.85, fractal_noise(size, 48, rng, 2))
    tone = np.clip(0.5 * coarse + 0.3 * grain + 0.1 - 0.4 * pores, 0, 1)
    return texture(ramp(tone, (0.1, 0.1, 0.095), (0.32, 0.31, 0.29), (0.5, 0.48, 0.45)), tone, 0.4 * coarse)


def _roof_tiles(size: int, rng: Generator) -> Texture:
    y, x = coordinates(size)
    row = np.floor(y * 8)
    along = x * 10 + 0.5 * (row % 2)
    piece = (row * 10 + np.floor(along) % 10).astype(np.int64)
    arch = np.abs(along % 1 - 0.5) * 2
    height = np.sqrt(np.maximum(1 - arch**2, 0)) * (0.4 + 0.6 * (y * 8 % 1))
    grain = fractal_noise(size, 24, rng, 4, 0.7)
    tone = np.clip(0.2 + 0.5 * per_piece(piece, rng) + 0.5 * (grain - 0.5), 0, 1)
    moss = (smoothstep(0.6, 0.85, fractal_noise(size, 3, rng, 5)) * 0.6)[..., None]
    color = ramp(tone, (0.14, 0.055, 0.035), (0.33, 0.13, 0.075), (0.45, 0.24, 0.15)) * (
        0.25 + 0.75 * height[..., None]
    )
    return texture(
        color * (1 - moss) + np.array([0.1, 0.11, 0.05], np.float32) * moss, height.astype(np.float32), 0.3 * grain
    )


def _tiles(size: int, rng: Generator) -> Texture:
    inside, piece = courses(size, 4, 4, 0.008, 0.0)
    y, x = coordinates(size)
    u, v = (x * 4) % 1 - 0.5, (y * 4) % 1 - 0.5
    star = np.hypot(u, v) * (1 + 0.25 * np.cos(4 * np.arctan2(v, u)))
    motif = smoothstep(0.0, 0.03, 0.33 - star.astype(np.float32)) - 0.8 * smoothstep(
        0.0, 0.03, 0.2 - star.astype(np.float32)
    )
    glaze = fractal_noise(size, 8, rng, 4) * 0.5 + per_piece(piece, rng) * 0.5
    hue = rng.dirichlet((2, 2, 3)) * 0.6
    body = ramp(glaze, (0.5, 0.47, 0.4), (0.66, 0.63, 0.56))
    ink = np.clip(motif, 0, 1)[..., None]
    color = body * (1 - ink) + hue.astype(np.float32) * (0.6 + 0.5 * glaze[..., None]) * ink
    mask = inside[..., None]
    return texture(color * mask + np.array([0.3, 0.29, 0.27], np.float32) * (1 - mask), inside, inside)


def _marble(size: int, rng: Generator) -> Texture:
    y, x = coordinates(size)
    warp = fractal_noise(size, 3, rng, 6, 0.6)
    veins = 1 - np.abs(np.sin(np.pi * (2 * x + 2 * y + 4 * warp)))
    tone = np.clip(smoothstep(0.6, 1.0, veins.astype(np.float32)) + 0.3 * fractal_noise(size, 6, rng, 5), 0, 1)
    return texture(ramp(tone, (0.72, 0.7, 0.66), (0.5, 0.48, 0.46), (0.22, 0.22, 0.23)))


def _metal(size: int, rng: Generator) -> Texture:
    brushed = fractal_noise(size, (64, 2), rng, 3, 0.7)
    rust = smoothstep(0.62, 0.9, fractal_noise(size, 5, rng, 5, 0.6))[..., None]
    color = (
        ramp(brushed, (0.42, 0.42, 0.43), (0.62, 0.62, 0.62)) * (1 - rust)
        + np.array([0.26, 0.12, 0.05], np.float32) * rust
    )
    return texture(color, brushed, 1 - 0.9 * rust[..., 0])


def _planks(size: int, rng: Generator) -> Texture:
    inside, piece = courses(size, 8, 2, 0.004, 0.37)
    fibre = fractal_noise(size, (96, 4), rng, 3, 0.7)
    warp = fractal_noise(size, (16, 2), rng, 3)
    rings = 0.5 + 0.5 * np.sin(2 * np.pi * (2.5 * warp + 3 * per_piece(piece, rng)))
    tone = np.clip(0.3 * rings + 0.3 * fibre + 0.4 * per_piece(piece, rng), 0, 1)
    color = ramp(tone, (0.13, 0.065, 0.03), (0.33, 0.19, 0.095), (0.53, 0.36, 0.21))
    return texture(color * (0.15 + 0.85 * inside[..., None]), inside * 0.9 + fibre * 0.1, inside * (0.5 + 0.5 * tone))


def _parquet(size: int, rng: Generator) -> Texture:
    y, x = coordinates(size)
    block_y, block_x = np.floor(y * 4).astype(np.int64), np.floor(x * 4).astype(np.int64)
    turned = (block_y + block_x) % 2 == 1
    strip = np.floor(np.where(turned, x, y) * 16).astype(np.int64) % 4
    within = (np.where(turned, x, y) * 16) % 1
    piece = (block_y * 4 + block_x) * 4 + strip
    fibre = np.where(turned, fractal_noise(size, (4, 96), rng, 2), fractal_noise(size, (96, 4), rng, 2))
    tone = np.clip(0.4 * fibre + 0.6 * per_piece(piece, rng), 0, 1)
    inside = smoothstep(0.02, 0.1, np.minimum(within, 1 - within).astype(np.float32))
    color = ramp(tone, (0.17, 0.085, 0.035), (0.36, 0.21, 0.1), (0.5, 0.33, 0.18))
    return texture(color * (0.3 + 0.7 * inside[..., None]), inside, inside)


def _wood(size: int, rng: Generator) -> Texture:
    y, _ = coordinates(size)
    warp = fractal_noise(size, (4, 1), rng, 3)
    rings = 0.5 + 0.5 * np.sin(2 * np.pi * (8 * y + 2.2 * warp))
    fibre = fractal_noise(size, (64, 2), rng, 3, 0.7)
    tone = np.clip(0.5 * rings + 0.5 * fibre, 0, 1)
    return texture(ramp(tone, (0.25, 0.14, 0.07), (0.38, 0.23, 0.12), (0.48, 0.31, 0.17)), fibre, 0.6 + 0.4 * tone)


PROCEDURES: dict[str, Callable[[int, Generator], Texture]] = {
    "bricks": _bricks,
    "concrete": _concrete,
    "marble": _marble,
    "metal": _metal,
    "parquet": _parquet,
    "planks": _planks,
    "plaster": _plaster,
    "roof_tiles": _roof_tiles,
    "rubble": _rubble,
    "tiles": _tiles,
    "wood": _wood,
}
