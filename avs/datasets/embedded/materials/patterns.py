"""Parts that procedural textures are made of: colour ramps, bonds of stones, edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float32]
Floats = npt.NDArray[np.floating]
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


def texture(color: Floats, height: Floats | None = None, gloss: Floats | None = None) -> Texture:
    """Return a texture of these fields, clipped to their ranges; without relief and fully glossy by default."""
    size = color.shape[:2]
    height = np.zeros(size) if height is None else height
    gloss = np.ones(size) if gloss is None else gloss
    color, height, gloss = np.clip(color, 0.004, 0.96), np.clip(height, 0, 1), np.clip(gloss, 0, 1)
    return Texture(color.astype(np.float32), height.astype(np.float32), gloss.astype(np.float32))


def ramp(values: Floats, *colors: tuple[float, float, float]) -> Array:
    """Return colours ``[..., 3]`` interpolated between evenly spaced ``colors`` at ``values`` in 0..1."""
    table = np.array(colors, np.float32)
    stops = np.linspace(0, 1, len(table))
    return np.stack([np.interp(values, stops, table[:, channel]) for channel in range(3)], axis=-1).astype(np.float32)


def smoothstep(low: float, high: float, values: Floats) -> Array:
    """Return 0 below ``low``, 1 above ``high``, and a smooth passage between."""
    part = np.clip((values - low) / (high - low), 0, 1)
    return np.asarray(part * part * (3 - 2 * part), np.float32)


def coordinates(size: int) -> tuple[Array, Array]:
    """Return the rows' and the columns' position ``[size, size]`` in 0..1 of each texel."""
    axis = (np.arange(size, dtype=np.float32) + 0.5) / size
    return np.meshgrid(axis, axis, indexing="ij")


def courses(size: int, rows: int, columns: int, joint: float, shift: float) -> tuple[Array, npt.NDArray[np.int64]]:
    """Lay a bond of ``rows`` x ``columns`` pieces: distance into each piece from its joint, and its index."""
    y, x = coordinates(size)
    row = np.floor(y * rows)
    along = x * columns + shift * (row % 2)
    column = np.floor(along)
    edge_y = np.minimum(y * rows - row, row + 1 - y * rows) / rows
    edge_x = np.minimum(along - column, column + 1 - along) / columns
    inside = smoothstep(joint * 0.5, joint, np.minimum(edge_x, edge_y).astype(np.float32))
    return inside, (row * columns + column % columns).astype(np.int64)


def per_piece(index: npt.NDArray[np.int64], rng: Generator) -> Array:
    """Return a random number in 0..1 for each piece, at every texel of it."""
    return rng.random(int(index.max()) + 1, dtype=np.float32)[index]
