"""Textures of fabric, paper and glaze."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from avs.datasets.embedded.materials.noise import fractal_noise
from avs.datasets.embedded.materials.patterns import Generator, Texture, coordinates, ramp, smoothstep, texture


def _weave(size: int, rng: Generator) -> Texture:
    y, x = coordinates(size)
    threads = np.sin(np.pi * 64 * x) * np.sin(np.pi * 64 * y)
    slub = fractal_noise(size, (64, 3), rng, 2) * 0.5 + fractal_noise(size, (3, 64), rng, 2) * 0.5
    tone = np.clip(0.5 + 0.18 * threads + 0.6 * (slub - 0.5) + 0.3 * (fractal_noise(size, 3, rng, 4) - 0.5), 0, 1)
    return texture(
        ramp(tone.astype(np.float32), (0.22, 0.21, 0.2), (0.75, 0.73, 0.7)), tone.astype(np.float32), 0.1 * slub
    )


def _check(size: int, rng: Generator) -> Texture:
    y, x = coordinates(size)
    first, second = ((x * 6) % 1 < 0.5).astype(np.float32), ((y * 6) % 1 < 0.5).astype(np.float32)
    thread = 0.85 + 0.3 * (_weave(size, rng).height - 0.5)
    dark = rng.dirichlet((1.2, 1.2, 1.2)).astype(np.float32) * 0.7
    color = (
        np.array([0.68, 0.66, 0.6], np.float32) * (1 - 0.5 * (first + second))[..., None]
        + dark * (0.5 * (first + second))[..., None]
    )
    return texture(color * thread[..., None], thread - 0.5)


def _carpet(size: int, rng: Generator) -> Texture:
    quarter = fractal_noise(size, 5, rng, 4)
    ornament = quarter + quarter[::-1] + quarter[:, ::-1] + quarter[::-1, ::-1]
    ornament = (ornament + ornament.T) / 8
    ornament = (ornament - ornament.min()) / np.ptp(ornament)
    y, x = coordinates(size)
    edge = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y))
    bands = np.floor(ornament * 7 + 3 * (edge < 0.16) + 2 * (edge < 0.05)).astype(np.int64)
    base = rng.dirichlet((3, 3, 3), 13) * rng.uniform(0.2, 1.0, (13, 1))
    warm = np.array([0.45, 0.12, 0.08], np.float32) * rng.uniform(0.3, 1)
    pile = 0.75 + 0.5 * (fractal_noise(size, 64, rng, 2) - 0.5)
    color = (0.45 * base[bands % 13] + 0.55 * warm).astype(np.float32) * pile[..., None]
    return texture(color, pile - 0.25)


def _wallpaper(size: int, rng: Generator) -> Texture:
    y, x = coordinates(size)
    stripe = 0.5 + 0.5 * np.sign(np.sin(2 * np.pi * 6 * x))
    leaf = smoothstep(
        0.72,
        0.75,
        (0.5 + 0.5 * np.sin(2 * np.pi * (6 * x + 0.3 * np.sin(2 * np.pi * 6 * y))) * np.cos(2 * np.pi * 9 * y)).astype(
            np.float32
        ),
    )
    base = (rng.uniform(0.4, 0.75) + 0.12 * rng.random(3)).astype(np.float32)
    other = np.clip(base * (rng.uniform(0.75, 0.95) + 0.06 * rng.normal(size=3)), 0, 1).astype(np.float32)
    color = base * (1 - stripe[..., None]) + other * stripe[..., None]
    color = color * (1 - 0.3 * leaf[..., None]) * (0.92 + 0.16 * fractal_noise(size, 4, rng, 5)[..., None])
    return texture(color, leaf)


def _glaze(size: int, rng: Generator) -> Texture:
    y, x = coordinates(size)
    warp = fractal_noise(size, 4, rng, 4)
    bands = np.floor((y + 0.03 * warp) * 14).astype(np.int64)
    hues = (0.12 + rng.dirichlet((2, 2, 2)) * rng.uniform(0.3, 1.2, (15, 1)) + 0.1 * rng.random((15, 3))) * 0.8
    wave = ((np.sin(2 * np.pi * (12 * x + 2 * warp)) > 0.2) & (bands % 3 == 1)).astype(np.float32)[..., None]
    color = (
        np.clip(hues[bands % 15], 0, 0.9).astype(np.float32) * (1 - wave)
        + np.array([0.7, 0.66, 0.58], np.float32) * wave
    )
    return texture(color * (0.8 + 0.3 * fractal_noise(size, 16, rng, 4)[..., None]))


def _paper(size: int, rng: Generator) -> Texture:
    y, _ = coordinates(size)
    leaves = fractal_noise(size, (128, 1), rng, 1)
    return texture(
        np.repeat((0.55 + 0.3 * leaves + 0.05 * np.sin(40 * y))[..., None], 3, axis=2)
        * np.array([1, 0.95, 0.85], np.float32),
        leaves,
    )


PROCEDURES: dict[str, Callable[[int, Generator], Texture]] = {
    "carpet": _carpet,
    "check": _check,
    "glaze": _glaze,
    "paper": _paper,
    "wallpaper": _wallpaper,
    "weave": _weave,
}
