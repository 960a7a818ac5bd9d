"""Sky, sun, lamps and windows.

Light is in radiance units; irradiance is kept divided by pi, so that a white surface under irradiance 1 has radiance 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.geometry.mesh_model import Array, Color, unit
from avs.datasets.embedded.materials.noise import fractal_noise

OFFSET = 2e-3
"""Metres that a ray starts above its surface, so that it does not meet the surface itself."""


@dataclass(frozen=True)
class Sun:
    """Directional light; ``radiance`` is its irradiance over pi on a surface that faces it."""

    direction: tuple[float, float, float]
    radiance: Color
    angular_radius: float = 0.009


@dataclass(frozen=True)
class Lamp:
    """Ball of light at ``position``; ``intensity`` is its irradiance over pi at one metre."""

    position: tuple[float, float, float]
    intensity: Color
    radius: float = 0.06
    sharp: bool = False
    """Whether each sample casts a shadow ray of its own; else the light is stored at the vertices."""


@dataclass(frozen=True)
class Window:
    """Rectangle through which the sky lights a room; ``right`` x ``up`` points into the room."""

    corner: tuple[float, float, float]
    right: tuple[float, float, float]
    up: tuple[float, float, float]


class Sky:
    """Radiance of the sky by direction: a gradient, a halo about the sun, clouds; below the horizon, the ground."""

    def __init__(
        self, zenith: Color, horizon: Color, below: Color, sun: Sun | None, cloudiness: float, rng: np.random.Generator
    ) -> None:
        """Paint the sky into a panorama of 128 x 512 samples; ``cloudiness`` is 0 (clear) to 1 (overcast)."""
        rows, columns = 128, 512
        elevation = (0.5 - (np.arange(rows) + 0.5) / rows) * np.pi
        azimuth = ((np.arange(columns) + 0.5) / columns) * 2 * np.pi
        direction = np.stack(
            np.broadcast_arrays(
                np.cos(elevation)[:, None] * np.cos(azimuth),
                np.cos(elevation)[:, None] * np.sin(azimuth),
                np.sin(elevation)[:, None],
            ),
            -1,
        )
        up = np.clip(direction[..., 2:], 0, 1)
        blend = (1 - up) ** 3.5
        clear = np.asarray(zenith) * (1 - blend) + np.asarray(horizon) * blend
        if sun is not None:
            toward = np.clip(direction @ unit(np.asarray(sun.direction)), 0, 1)[..., None]
            clear = clear + np.asarray(sun.radiance) * (0.05 * toward**8 + 0.25 * toward**120)
        clouds = self._clouds(direction, cloudiness, rng)
        bright = np.asarray(horizon).mean() * np.array([1.15, 1.15, 1.18])
        clear = clear * (1 - clouds[..., :1]) + bright * clouds[..., 1:] * clouds[..., :1]
        edge = np.clip(direction[..., 2:] * 25 + 0.5, 0, 1)
        self.panorama = (clear * edge + np.asarray(below) * (1 - edge)).astype(np.float32)

        self._rings = self.panorama.mean(axis=1)

    def blurred(self, upward: Array) -> Array:
        """Return the mean radiance ``[n, 3]`` of all directions whose vertical part is ``upward`` ``[n]``."""
        rows = len(self._rings)
        # Close to the elevation itself; a rough surface does not show the difference.
        index = ((0.5 - 0.5 * upward) * rows).astype(np.int64)
        return np.asarray(self._rings[np.clip(index, 0, rows - 1)])

    @staticmethod
    def _clouds(
        direction: npt.NDArray[np.floating], cloudiness: float, rng: np.random.Generator
    ) -> npt.NDArray[np.floating]:
        """Return cover and brightness ``[..., 2]`` of clouds on a plane high above."""
        size = 256
        field = fractal_noise(size, 4, rng, 6, 0.55)
        height = np.maximum(direction[..., 2], 0.02)
        # 0.6 is the height of the curved layer: the bend keeps clouds near the horizon from shrinking to lines.
        plane = direction[..., :2] / (height[..., None] + 0.25) * 0.35
        index = np.floor(plane * size).astype(np.int64) % size
        density = field[index[..., 0], index[..., 1]]
        threshold = 0.85 - 0.75 * cloudiness
        cover = np.clip((density - threshold) / 0.3, 0, 1) * np.clip(direction[..., 2] * 8, 0, 1)
        return np.stack([cover, 1.05 - 0.45 * np.clip(density - threshold, 0, 1)], -1)

    def __call__(self, directions: Array, smooth: bool = True) -> Array:
        """Return the radiance ``[n, 3]`` seen along unit ``directions`` ``[n, 3]``, interpolated if ``smooth``."""
        rows, columns = self.panorama.shape[:2]
        row = (0.5 - np.arcsin(np.clip(directions[:, 2], -1, 1)) * np.float32(1 / np.pi)) * rows
        column = np.arctan2(directions[:, 1], directions[:, 0]) * np.float32(columns / (2 * np.pi)) % columns
        if not smooth:
            nearest = np.minimum(row.astype(np.int64), rows - 1), np.minimum(column.astype(np.int64), columns - 1)
            return np.asarray(self.panorama[nearest])
        row, column = row - 0.5, column - 0.5
        row0, column0 = np.floor(row).astype(np.int64), np.floor(column).astype(np.int64)
        fy, fx = (row - row0).astype(np.float32)[:, None], (column - column0).astype(np.float32)[:, None]
        top, bottom = np.clip(row0, 0, rows - 1), np.clip(row0 + 1, 0, rows - 1)
        left, right = column0 % columns, (column0 + 1) % columns
        p = self.panorama
        upper = p[top, left] * (1 - fx) + p[top, right] * fx
        lower = p[bottom, left] * (1 - fx) + p[bottom, right] * fx
        return np.asarray(upper * (1 - fy) + lower * fy)


@dataclass(frozen=True)
class Lighting:
    """All light of a scene. With ``windows``, the sky lights surfaces through them alone."""

    sky: Sky
    sun: Sun | None = None
    lamps: tuple[Lamp, ...] = ()
    windows: tuple[Window, ...] = ()
    interior: tuple[float, float, float, float] | None = None
    """Extent (x0, y0, x1, y1) of the building to which ``windows`` belong; outside of it the open sky counts."""
    haze: float = 0.0
    """Share of light that a metre of air replaces by the colour of the horizon."""


def frame(normal: Array) -> tuple[Array, Array]:
    """Return two unit vectors ``[n, 3]`` that complete ``normal`` to an orthogonal frame (Duff et al. 2017)."""
    x, y, z = normal.T
    sign = np.where(z >= 0, np.float32(1), np.float32(-1))
    a = -1 / (sign + z)
    b = x * y * a
    return np.stack([1 + sign * x * x * a, sign * b, -sign * x], -1), np.stack([b, sign + y * y * a, -y], -1)


def sun_directions(sun: Sun, draws: Array) -> Array:
    """Return directions ``[n, 3]`` to points of the sun's disc; ``draws`` ``[n, 2 or more]`` are in 0..1."""
    center = unit(np.asarray(sun.direction, np.float32)[None])
    return unit(center + _disc(center, draws) * np.float32(sun.angular_radius))


def lamp_directions(lamp: Lamp, points: Array, draws: Array) -> Array:
    """Return the ways ``[n, 3]`` from ``points`` to places on the disc that the lamp's ball shows them."""
    way = np.asarray(lamp.position, np.float32) - points
    return np.asarray(way + _disc(unit(way), draws) * np.float32(lamp.radius))


def _disc(axis: Array, draws: Array) -> Array:
    """Return points ``[n, 3]`` of unit discs about the origin, at right angles to ``axis`` ``[n or 1, 3]``."""
    tangent, bitangent = frame(axis)
    radius, angle = np.sqrt(draws[:, 0]), np.float32(2 * np.pi) * draws[:, 1]
    return np.asarray((radius * np.cos(angle))[:, None] * tangent + (radius * np.sin(angle))[:, None] * bitangent)
