"""Textures: colour, relief and gloss of surfaces, from photographs and procedural noise. All repeat without a seam."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.noise import cellular, fractal_noise
from avs.datasets.embedded.photographs import CROPS, grey, photograph, tileable

Array = npt.NDArray[np.float32]
Generator = np.random.Generator


@dataclass(frozen=True)
class Texture:
    """One repeat of a surface, ``size`` texels square.

    Attributes:
        color: ``[size, size, 3]`` linear reflectance in 0..1; a material's tint multiplies it.
        height: ``[size, size]`` relief in 0..1 of the material's relief.
        gloss: ``[size, size]`` factor in 0..1 on the strength of reflections.
    """

    color: Array
    height: Array
    gloss: Array


def make_texture(name: str, size: int, seed: int) -> Texture:
    """Return the texture ``name`` (a key of ``PROCEDURES`` or of ``photographs.CROPS``) at ``size`` texels square."""
    if name not in PROCEDURES:
        return _plain(photograph(name, size))
    # crc32, because hash() of a string differs from process to process.
    return PROCEDURES[name](size, np.random.default_rng([seed, zlib.crc32(name.encode())]))


def _plain(color: Array, height: Array | None = None, gloss: Array | None = None) -> Texture:
    size = color.shape[:2]
    height = np.zeros(size, np.float32) if height is None else np.asarray(height, np.float32)
    gloss = np.ones(size, np.float32) if gloss is None else np.asarray(gloss, np.float32)
    return Texture(np.clip(color, 0.004, 0.96).astype(np.float32), np.clip(height, 0, 1), np.clip(gloss, 0, 1))


def _ramp(values: Array, *colors: tuple[float, float, float]) -> Array:
    """Return colours ``[..., 3]`` interpolated between evenly spaced ``colors`` at ``values`` in 0..1."""
    table = np.array(colors, np.float32)
    stops = np.linspace(0, 1, len(table))
    return np.stack([np.interp(values, stops, table[:, channel]) for channel in range(3)], axis=-1).astype(np.float32)


def _smoothstep(low: float, high: float, values: Array) -> Array:
    part = np.clip((values - low) / (high - low), 0, 1)
    return np.asarray(part * part * (3 - 2 * part), np.float32)


def _coordinates(size: int) -> tuple[Array, Array]:
    axis = (np.arange(size, dtype=np.float32) + 0.5) / size
    return np.meshgrid(axis, axis, indexing="ij")  # type: ignore[return-value]


def _courses(size: int, rows: int, columns: int, joint: float, shift: float) -> tuple[Array, npt.NDArray[np.int64]]:
    """Lay a bond of ``rows`` x ``columns`` pieces: distance into each piece from its joint, and its index."""
    y, x = _coordinates(size)
    row = np.floor(y * rows)
    along = x * columns + shift * (row % 2)
    column = np.floor(along)
    edge_y = np.minimum(y * rows - row, row + 1 - y * rows) / rows
    edge_x = np.minimum(along - column, column + 1 - along) / columns
    inside = _smoothstep(joint * 0.5, joint, np.minimum(edge_x, edge_y).astype(np.float32))
    return inside, (row * columns + column % columns).astype(np.int64)


def _per_piece(index: npt.NDArray[np.int64], rng: Generator) -> Array:
    return rng.random(int(index.max()) + 1, dtype=np.float32)[index]


def _bricks(size: int, rng: Generator) -> Texture:
    inside, piece = _courses(size, 12, 4, 0.012, 0.5)
    grain = tileable(grey("moon", size)) * 0.4 + fractal_noise(size, 16, rng, 5, 0.7) * 0.6
    tone = np.clip(0.25 + 0.5 * _per_piece(piece, rng) + 0.5 * (grain - 0.5), 0, 1)
    clay = _ramp(tone, (0.11, 0.045, 0.03), (0.30, 0.12, 0.075), (0.46, 0.24, 0.15))
    mortar = _ramp(grain, (0.28, 0.26, 0.23), (0.5, 0.47, 0.42))
    soot = 0.75 + 0.25 * fractal_noise(size, 3, rng, 3)
    mask = inside[..., None]
    return _plain((clay * mask + mortar * (1 - mask)) * soot[..., None], inside * 0.8 + grain * 0.2, 0.3 * inside)


def _paving(size: int, rng: Generator) -> Texture:
    stone = tileable(grey("brick", size).T.copy())
    wear = fractal_noise(size, 3, rng, 4)
    color = _ramp(stone, (0.08, 0.07, 0.06), (0.3, 0.25, 0.21), (0.52, 0.46, 0.4)) * (0.7 + 0.5 * wear[..., None])
    return _plain(color, stone, stone * 0.5)


def _grass(size: int, rng: Generator) -> Texture:
    blades = tileable(grey("grass", size))
    patch = fractal_noise(size, 4, rng, 4)
    fresh = _ramp(blades, (0.012, 0.022, 0.006), (0.07, 0.12, 0.025), (0.25, 0.33, 0.1))
    dry = _ramp(blades, (0.03, 0.026, 0.01), (0.17, 0.15, 0.06), (0.42, 0.38, 0.19))
    weight = (_smoothstep(0.45, 0.9, patch) * 0.7)[..., None]
    return _plain(fresh * (1 - weight) + dry * weight, blades, blades * 0.3)


def _gravel(size: int, rng: Generator) -> Texture:
    stones = tileable(grey("gravel", size))
    hue = fractal_noise(size, 12, rng, 3)[..., None]
    cold = _ramp(stones, (0.03, 0.03, 0.03), (0.2, 0.2, 0.2), (0.55, 0.55, 0.55))
    warm = _ramp(stones, (0.04, 0.03, 0.02), (0.27, 0.21, 0.16), (0.6, 0.53, 0.44))
    return _plain(cold * (1 - hue) + warm * hue, stones, stones * 0.4)


def _soil(size: int, rng: Generator) -> Texture:
    crumbs = 0.5 * fractal_noise(size, 24, rng, 4, 0.8) + 0.5 * tileable(grey("gravel", size))
    leaves = _smoothstep(0.62, 0.7, fractal_noise(size, 20, rng, 2))[..., None]
    ground = _ramp(crumbs, (0.02, 0.014, 0.01), (0.1, 0.07, 0.045), (0.25, 0.19, 0.13))
    return _plain(ground * (1 - leaves) + np.float32([0.24, 0.15, 0.06]) * leaves * (0.5 + crumbs[..., None]), crumbs)


def _cobbles(size: int, rng: Generator) -> Texture:
    distance, border, cell = cellular(size, 9, rng, 0.55)
    inside = _smoothstep(0.04, 0.2, border)
    grain = fractal_noise(size, 32, rng, 4, 0.7)
    tone = np.clip(0.2 + 0.5 * _per_piece(cell, rng) + 0.5 * (grain - 0.5), 0, 1)
    color = _ramp(tone, (0.09, 0.09, 0.1), (0.25, 0.24, 0.23), (0.42, 0.38, 0.33))
    joint = _ramp(grain, (0.03, 0.035, 0.02), (0.12, 0.1, 0.07))
    height = inside * (1 - 0.4 * distance)
    return _plain(color * inside[..., None] + joint * (1 - inside[..., None]), height, inside * 0.6)


def _rubble(size: int, rng: Generator) -> Texture:
    _, border, cell = cellular(size, 6, rng, 0.3)
    inside = _smoothstep(0.03, 0.12, border)
    grain = 0.6 * fractal_noise(size, 16, rng, 5, 0.7) + 0.4 * tileable(grey("moon", size))
    tone = np.clip(0.3 * grain + 0.7 * _per_piece(cell, rng), 0, 1)
    stone = _ramp(tone, (0.16, 0.13, 0.1), (0.33, 0.29, 0.23), (0.5, 0.46, 0.39)) * (0.55 + 0.8 * grain[..., None])
    mortar = _ramp(grain, (0.2, 0.18, 0.15), (0.4, 0.37, 0.32))
    mask = inside[..., None]
    return _plain(stone * mask + mortar * (1 - mask), inside * (0.6 + 0.4 * grain), 0.2 * inside)


def _wood(size: int, rng: Generator) -> Texture:
    y, _ = _coordinates(size)
    warp = fractal_noise(size, (4, 1), rng, 3)
    rings = 0.5 + 0.5 * np.sin(2 * np.pi * (8 * y + 2.2 * warp))
    fibre = fractal_noise(size, (64, 2), rng, 3, 0.7)
    tone = np.clip(0.5 * rings + 0.5 * fibre, 0, 1)
    return _plain(_ramp(tone, (0.2, 0.1, 0.045), (0.4, 0.235, 0.115), (0.56, 0.37, 0.2)), fibre, 0.6 + 0.4 * tone)


def _planks(size: int, rng: Generator) -> Texture:
    inside, piece = _courses(size, 8, 2, 0.004, 0.37)
    fibre = fractal_noise(size, (96, 4), rng, 3, 0.7)
    warp = fractal_noise(size, (16, 2), rng, 3)
    rings = 0.5 + 0.5 * np.sin(2 * np.pi * (2.5 * warp + 3 * _per_piece(piece, rng)))
    tone = np.clip(0.3 * rings + 0.3 * fibre + 0.4 * _per_piece(piece, rng), 0, 1)
    color = _ramp(tone, (0.13, 0.065, 0.03), (0.33, 0.19, 0.095), (0.53, 0.36, 0.21))
    return _plain(color * (0.15 + 0.85 * inside[..., None]), inside * 0.9 + fibre * 0.1, inside * (0.5 + 0.5 * tone))


def _parquet(size: int, rng: Generator) -> Texture:
    y, x = _coordinates(size)
    block_y, block_x = np.floor(y * 4).astype(np.int64), np.floor(x * 4).astype(np.int64)
    turned = (block_y + block_x) % 2 == 1
    strip = np.floor(np.where(turned, x, y) * 16).astype(np.int64) % 4
    within = (np.where(turned, x, y) * 16) % 1
    piece = (block_y * 4 + block_x) * 4 + strip
    fibre = np.where(turned, fractal_noise(size, (4, 96), rng, 2), fractal_noise(size, (96, 4), rng, 2))
    tone = np.clip(0.4 * fibre + 0.6 * _per_piece(piece, rng), 0, 1)
    inside = _smoothstep(0.02, 0.1, np.minimum(within, 1 - within).astype(np.float32))
    color = _ramp(tone, (0.17, 0.085, 0.035), (0.36, 0.21, 0.1), (0.5, 0.33, 0.18))
    return _plain(color * (0.3 + 0.7 * inside[..., None]), inside, inside)


def _marble(size: int, rng: Generator) -> Texture:
    y, x = _coordinates(size)
    warp = fractal_noise(size, 3, rng, 6, 0.6)
    veins = 1 - np.abs(np.sin(np.pi * (2 * x + 2 * y + 4 * warp)))
    tone = np.clip(_smoothstep(0.6, 1.0, veins.astype(np.float32)) + 0.3 * fractal_noise(size, 6, rng, 5), 0, 1)
    return _plain(_ramp(tone, (0.72, 0.7, 0.66), (0.5, 0.48, 0.46), (0.22, 0.22, 0.23)))


def _tiles(size: int, rng: Generator) -> Texture:
    inside, piece = _courses(size, 4, 4, 0.008, 0.0)
    y, x = _coordinates(size)
    u, v = (x * 4) % 1 - 0.5, (y * 4) % 1 - 0.5
    star = np.hypot(u, v) * (1 + 0.25 * np.cos(4 * np.arctan2(v, u)))
    motif = _smoothstep(0.0, 0.03, 0.33 - star.astype(np.float32)) - 0.8 * _smoothstep(
        0.0, 0.03, 0.2 - star.astype(np.float32)
    )
    glaze = fractal_noise(size, 8, rng, 4) * 0.5 + _per_piece(piece, rng) * 0.5
    hue = rng.dirichlet((2, 2, 3)) * 0.6
    body = _ramp(glaze, (0.5, 0.47, 0.4), (0.66, 0.63, 0.56))
    ink = np.clip(motif, 0, 1)[..., None]
    color = body * (1 - ink) + hue.astype(np.float32) * (0.6 + 0.5 * glaze[..., None]) * ink
    mask = inside[..., None]
    return _plain(color * mask + np.float32([0.3, 0.29, 0.27]) * (1 - mask), inside, inside)


def _plaster(size: int, rng: Generator) -> Texture:
    coarse, fine = fractal_noise(size, 3, rng, 6, 0.6), fractal_noise(size, 48, rng, 3, 0.8)
    stain = _smoothstep(0.5, 0.95, fractal_noise(size, (2, 6), rng, 5, 0.6))
    tone = np.clip(0.62 + 0.35 * (coarse - 0.5) + 0.22 * (fine - 0.5) - 0.22 * stain, 0, 1)
    return _plain(_ramp(tone, (0.1, 0.095, 0.085), (0.8, 0.78, 0.74)), 0.5 * coarse + 0.5 * fine, 0.3 * fine)


def _concrete(size: int, rng: Generator) -> Texture:
    coarse = fractal_noise(size, 4, rng, 6, 0.7)
    grain = tileable(grey("moon", size))
    pores = _smoothstep(0.78, 0.85, fractal_noise(size, 48, rng, 2))
    tone = np.clip(0.5 * coarse + 0.3 * grain + 0.1 - 0.4 * pores, 0, 1)
    return _plain(_ramp(tone, (0.1, 0.1, 0.095), (0.32, 0.31, 0.29), (0.5, 0.48, 0.45)), tone, 0.4 * coarse)


def _bark(size: int, rng: Generator) -> Texture:
    ridges = 1 - np.abs(2 * fractal_noise(size, (3, 12), rng, 4, 0.6) - 1)
    grain = fractal_noise(size, 32, rng, 3)
    tone = np.clip(1.3 * ridges - 0.4 + 0.4 * (grain - 0.5), 0, 1)
    moss = (_smoothstep(0.55, 0.8, fractal_noise(size, 3, rng, 4)) * 0.5)[..., None]
    color = _ramp(tone, (0.2, 0.16, 0.12), (0.11, 0.08, 0.055), (0.025, 0.018, 0.012))
    return _plain(color * (1 - moss) + np.float32([0.09, 0.12, 0.04]) * moss, 1 - tone)


def _leaf(size: int, rng: Generator) -> Texture:
    y, x = _coordinates(size)
    rib = np.abs(x - 0.5)
    veins = np.minimum(rib * 6, np.abs((y * 8 + rib * 6) % 1 - 0.5) * 4)
    tone = np.clip(
        0.45 + 0.5 * fractal_noise(size, 6, rng, 4) - 0.35 * _smoothstep(0.5, 0.0, veins.astype(np.float32)), 0, 1
    )
    return _plain(_ramp(tone, (0.12, 0.2, 0.06), (0.5, 0.6, 0.3), (0.8, 0.85, 0.55)), tone, 0.6 + 0.4 * tone)


def _foliage(size: int, rng: Generator) -> Texture:
    distance, border, cell = cellular(size, 22, rng)
    inside = _smoothstep(0.0, 0.25, border) * (1 - 0.7 * distance)
    tone = np.clip(inside * (0.35 + 0.8 * _per_piece(cell, rng)), 0, 1)
    gap = 0.35 + 0.65 * _smoothstep(0.3, 0.6, fractal_noise(size, 8, rng, 4))
    color = _ramp(tone, (0.006, 0.012, 0.004), (0.05, 0.085, 0.022), (0.2, 0.27, 0.08))
    return _plain(color * gap[..., None], inside, 0.6 * inside)


def _weave(size: int, rng: Generator) -> Texture:
    y, x = _coordinates(size)
    threads = np.sin(np.pi * 64 * x) * np.sin(np.pi * 64 * y)
    slub = fractal_noise(size, (64, 3), rng, 2) * 0.5 + fractal_noise(size, (3, 64), rng, 2) * 0.5
    tone = np.clip(0.5 + 0.18 * threads + 0.6 * (slub - 0.5) + 0.3 * (fractal_noise(size, 3, rng, 4) - 0.5), 0, 1)
    return _plain(
        _ramp(tone.astype(np.float32), (0.22, 0.21, 0.2), (0.75, 0.73, 0.7)), tone.astype(np.float32), 0.1 * slub
    )


def _check(size: int, rng: Generator) -> Texture:
    y, x = _coordinates(size)
    first, second = ((x * 6) % 1 < 0.5).astype(np.float32), ((y * 6) % 1 < 0.5).astype(np.float32)
    thread = 0.85 + 0.3 * (_weave(size, rng).height - 0.5)
    dark = rng.dirichlet((1.2, 1.2, 1.2)).astype(np.float32) * 0.7
    color = (
        np.float32([0.68, 0.66, 0.6]) * (1 - 0.5 * (first + second))[..., None]
        + dark * (0.5 * (first + second))[..., None]
    )
    return _plain(color * thread[..., None], thread - 0.5)


def _carpet(size: int, rng: Generator) -> Texture:
    quarter = fractal_noise(size, 5, rng, 4)
    ornament = quarter + quarter[::-1] + quarter[:, ::-1] + quarter[::-1, ::-1]
    ornament = (ornament + ornament.T) / 8
    ornament = (ornament - ornament.min()) / np.ptp(ornament)
    y, x = _coordinates(size)
    edge = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y))
    bands = np.floor(ornament * 7 + 3 * (edge < 0.16) + 2 * (edge < 0.05)).astype(np.int64)
    base = rng.dirichlet((1, 1, 1), 13) * rng.uniform(0.15, 0.9, (13, 1))
    warm = np.float32([0.45, 0.12, 0.08]) * rng.uniform(0.3, 1)
    pile = 0.75 + 0.5 * (fractal_noise(size, 64, rng, 2) - 0.5)
    color = (0.45 * base[bands % 13] + 0.55 * warm).astype(np.float32) * pile[..., None]
    return _plain(color, pile - 0.25)


def _wallpaper(size: int, rng: Generator) -> Texture:
    y, x = _coordinates(size)
    stripe = 0.5 + 0.5 * np.sign(np.sin(2 * np.pi * 6 * x))
    leaf = _smoothstep(
        0.72,
        0.75,
        (0.5 + 0.5 * np.sin(2 * np.pi * (6 * x + 0.3 * np.sin(2 * np.pi * 6 * y))) * np.cos(2 * np.pi * 9 * y)).astype(
            np.float32
        ),
    )
    base = (0.35 + 0.4 * rng.random(3)).astype(np.float32)
    other = np.clip(base * rng.uniform(0.65, 0.9, 3), 0, 1).astype(np.float32)
    color = base * (1 - stripe[..., None]) + other * stripe[..., None]
    color = color * (1 - 0.45 * leaf[..., None]) * (0.92 + 0.16 * fractal_noise(size, 4, rng, 5)[..., None])
    return _plain(color, leaf)


def _roof_tiles(size: int, rng: Generator) -> Texture:
    y, x = _coordinates(size)
    row = np.floor(y * 8)
    along = x * 10 + 0.5 * (row % 2)
    piece = (row * 10 + np.floor(along) % 10).astype(np.int64)
    arch = np.abs(along % 1 - 0.5) * 2
    height = np.sqrt(np.maximum(1 - arch**2, 0)) * (0.4 + 0.6 * (y * 8 % 1))
    grain = fractal_noise(size, 24, rng, 4, 0.7)
    tone = np.clip(0.2 + 0.5 * _per_piece(piece, rng) + 0.5 * (grain - 0.5), 0, 1)
    moss = (_smoothstep(0.6, 0.85, fractal_noise(size, 3, rng, 5)) * 0.6)[..., None]
    color = _ramp(tone, (0.14, 0.055, 0.035), (0.33, 0.13, 0.075), (0.45, 0.24, 0.15)) * (
        0.25 + 0.75 * height[..., None]
    )
    return _plain(color * (1 - moss) + np.float32([0.1, 0.11, 0.05]) * moss, height.astype(np.float32), 0.3 * grain)


def _metal(size: int, rng: Generator) -> Texture:
    brushed = fractal_noise(size, (64, 2), rng, 3, 0.7)
    rust = _smoothstep(0.62, 0.9, fractal_noise(size, 5, rng, 5, 0.6))[..., None]
    color = _ramp(brushed, (0.42, 0.42, 0.43), (0.62, 0.62, 0.62)) * (1 - rust) + np.float32([0.26, 0.12, 0.05]) * rust
    return _plain(color, brushed, 1 - 0.9 * rust[..., 0])


def _glaze(size: int, rng: Generator) -> Texture:
    y, x = _coordinates(size)
    warp = fractal_noise(size, 4, rng, 4)
    bands = np.floor((y + 0.03 * warp) * 14).astype(np.int64)
    hues = rng.dirichlet((1, 1, 1), 15) * rng.uniform(0.4, 1.3, (15, 1))
    wave = ((np.sin(2 * np.pi * (12 * x + 2 * warp)) > 0.2) & (bands % 3 == 1)).astype(np.float32)[..., None]
    color = np.clip(hues[bands % 15], 0, 0.9).astype(np.float32) * (1 - wave) + np.float32([0.7, 0.66, 0.58]) * wave
    return _plain(color * (0.8 + 0.3 * fractal_noise(size, 16, rng, 4)[..., None]))


def _fruit(size: int, rng: Generator) -> Texture:
    speckle = fractal_noise(size, 40, rng, 3, 0.8)
    blush = fractal_noise(size, 2, rng, 3)
    tone = np.clip(0.6 * blush + 0.4 * speckle, 0, 1)
    return _plain(_ramp(tone, (0.75, 0.42, 0.3), (0.9, 0.85, 0.7)), speckle)


def _paper(size: int, rng: Generator) -> Texture:
    y, _ = _coordinates(size)
    leaves = fractal_noise(size, (128, 1), rng, 1)
    return _plain(
        np.repeat((0.55 + 0.3 * leaves + 0.05 * np.sin(40 * y))[..., None], 3, axis=2) * np.float32([1, 0.95, 0.85]),
        leaves,
    )


def _stone(size: int, rng: Generator) -> Texture:
    coarse, grain = fractal_noise(size, 3, rng, 6, 0.65), tileable(grey("moon", size))
    lichen = _smoothstep(0.6, 0.75, fractal_noise(size, 7, rng, 5, 0.6))[..., None]
    color = _ramp(np.clip(0.6 * coarse + 0.4 * grain, 0, 1), (0.12, 0.11, 0.1), (0.36, 0.34, 0.31), (0.6, 0.57, 0.52))
    return _plain(
        color * (1 - 0.6 * lichen) + np.float32([0.3, 0.29, 0.16]) * 0.6 * lichen,
        0.6 * coarse + 0.4 * grain,
        0.3 * grain,
    )


PROCEDURES: dict[str, Callable[[int, Generator], Texture]] = {
    "bark": _bark,
    "bricks": _bricks,
    "carpet": _carpet,
    "check": _check,
    "cobbles": _cobbles,
    "concrete": _concrete,
    "foliage": _foliage,
    "fruit": _fruit,
    "glaze": _glaze,
    "grass": _grass,
    "gravel": _gravel,
    "leaf": _leaf,
    "marble": _marble,
    "metal": _metal,
    "paper": _paper,
    "parquet": _parquet,
    "paving": _paving,
    "planks": _planks,
    "plaster": _plaster,
    "roof_tiles": _roof_tiles,
    "rubble": _rubble,
    "soil": _soil,
    "stone": _stone,
    "tiles": _tiles,
    "wallpaper": _wallpaper,
    "weave": _weave,
    "wood": _wood,
}

PICTURES = ("astronaut", "cat", "coffee", "cameraman", "motorcycle", "rocket", "galaxies", "retina", "coins", "tissue")
assert set(PICTURES) <= set(CROPS)
