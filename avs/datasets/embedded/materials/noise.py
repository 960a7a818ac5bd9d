"""Periodic noise on the unit square, and smooth noise in space: the raw material of textures and terrain."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

Array = npt.NDArray[np.float32]


def value_noise(size: int, cells: tuple[int, int], rng: np.random.Generator) -> Array:
    """Return ``[size, size]`` smooth noise in 0..1 that repeats at the borders.

    Args:
        size: number of samples along each side.
        cells: number of lattice cells along the vertical and the horizontal side.
        rng: draws the lattice values.
    """
    lattice = rng.random(cells, dtype=np.float32)
    position = [(np.arange(size, dtype=np.float32) + 0.5) * (count / size) for count in cells]
    low = [p.astype(np.int64) for p in position]
    part = [p - i for p, i in zip(position, low, strict=True)]
    fade_y, fade_x = (f * f * (3 - 2 * f) for f in part)
    rows = lattice[low[0] % cells[0]] * (1 - fade_y)[:, None] + lattice[(low[0] + 1) % cells[0]] * fade_y[:, None]
    return np.asarray(rows[:, low[1] % cells[1]] * (1 - fade_x) + rows[:, (low[1] + 1) % cells[1]] * fade_x)


def fractal_noise(
    size: int, cells: int | tuple[int, int], rng: np.random.Generator, octaves: int = 5, gain: float = 0.5
) -> Array:
    """Return ``[size, size]`` periodic noise, the sum of octaves of doubling frequency, stretched to 0..1.

    Octaves finer than two samples per cell are left out, since they could only alias.
    """
    rows, columns = (cells, cells) if isinstance(cells, int) else cells
    total, weight = np.zeros((size, size), np.float32), 1.0
    for octave in range(octaves):
        count = (rows << octave, columns << octave)
        if max(count) > size // 2 and octave > 0:
            break
        total += weight * value_noise(size, (min(count[0], size), min(count[1], size)), rng)
        weight *= gain
    low, high = float(total.min()), float(total.max())
    return (total - low) / max(high - low, 1e-6)


def cellular(
    size: int, count: int, rng: np.random.Generator, regularity: float = 0.0
) -> tuple[Array, Array, npt.NDArray[np.int64]]:
    """Return periodic cellular noise (Worley 1996) of ``count`` squared cells.

    Args:
        size: number of samples along each side.
        count: cells along each side.
        rng: draws the cells' centres.
        regularity: 0 scatters the centres over their whole lattice cell, 1 puts them in its middle.

    Returns:
        distance: ``[size, size]`` to the nearest centre, in cells.
        border: ``[size, size]`` distance to the second nearest minus the nearest, in cells; 0 on the border.
        cell: ``[size, size]`` index of the nearest centre in 0..count² - 1.
    """
    corner = np.stack(np.meshgrid(np.arange(count), np.arange(count), indexing="ij"), -1).reshape(-1, 2)
    jitter = 0.5 + (rng.random((count * count, 2)) - 0.5) * (1 - regularity)
    tree = cKDTree((corner + jitter) % count, boxsize=count)
    axis = (np.arange(size) + 0.5) * (count / size)
    samples = np.stack(np.meshgrid(axis, axis, indexing="ij"), -1).reshape(-1, 2)
    distance, cell = tree.query(samples, k=2)
    shape = (size, size)
    nearest = distance[:, 0].reshape(shape).astype(np.float32)
    border = (distance[:, 1] - distance[:, 0]).reshape(shape).astype(np.float32)
    return nearest, border, cell[:, 0].reshape(shape)


class SpaceNoise:
    """Smooth random function of position, -1..1, with a period of 16 lattice cells."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Draw the lattice values from ``rng``."""
        self._lattice = rng.uniform(-1, 1, (16, 16, 16)).astype(np.float32)

    def __call__(self, points: npt.NDArray[np.floating], octaves: int = 4, gain: float = 0.5) -> Array:
        """Return ``[n]`` noise at ``points`` ``[n, 3]``, in lattice units; octaves double the frequency."""
        total, weight, norm = np.zeros(len(points), np.float32), 1.0, 0.0
        for octave in range(octaves):
            # The offset keeps the octaves' lattice points apart; without it the origin would be a fixed point of all.
            total += weight * self._trilinear(np.asarray(points) * 2.0**octave + 5.37 * octave)
            norm, weight = norm + weight, weight * gain
        return np.asarray(total / norm, dtype=np.float32)

    def _trilinear(self, points: npt.NDArray[np.floating]) -> Array:
        low = np.floor(points)
        part = points - low
        fade = part * part * (3 - 2 * part)
        index = low.astype(np.int64)
        total = np.zeros(len(points))
        for corner in np.ndindex(2, 2, 2):
            weight = np.prod(np.where(corner, fade, 1 - fade), axis=1)
            x, y, z = ((index + corner) & 15).T
            total += weight * self._lattice[x, y, z]
        return total.astype(np.float32)


def lumps(noise: SpaceNoise, height: float, frequency: float) -> Callable[[Array], Array]:
    """Return the function that maps points ``[n, 3]`` to ``height`` times ``noise`` at ``frequency`` per metre."""
    return lambda points: height * noise(points * frequency)
