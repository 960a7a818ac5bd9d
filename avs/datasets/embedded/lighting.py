"""Sky, sun, lamps and windows; and the light that surfaces pass on, gathered once per vertex.

Light is in radiance units; irradiance is kept divided by pi, so that a white surface under irradiance 1 has radiance 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.model import Array, Color, Model, unit
from avs.datasets.embedded.noise import fractal_noise
from avs.datasets.embedded.raycast import Caster, Hits

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


@dataclass(frozen=True)
class Window:
    """Rectangle through which the sky lights a room; ``right`` x ``up`` points into the room."""

    corner: tuple[float, float, float]
    right: tuple[float, float, float]
    up: tuple[float, float, float]


class Sky:
    """Radiance of the sky by direction: a gradient, haze, a halo about the sun, clouds; below the horizon, the ground."""

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
            return self.panorama[
                np.minimum(row.astype(np.int64), rows - 1), np.minimum(column.astype(np.int64), columns - 1)
            ]
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


@dataclass(frozen=True)
class BakedLight:
    """Light at the vertices of a model.

    Attributes:
        ambient: ``[v, 3]`` from the sky and from other surfaces, without direct sun and lamps.
        total: ``[v, 3]`` with them.
    """

    ambient: Array
    total: Array


def bake(
    model: Model, caster: Caster, lighting: Lighting, albedo: Array, rays: int, bounces: int, seed: int
) -> BakedLight:
    """Gather the light at each vertex: directly, and over ``bounces`` reflections.

    Args:
        model: the scene.
        caster: of the same triangles.
        lighting: its light.
        albedo: ``[materials, 3]`` mean reflectance of each material.
        rays: number of directions over the hemisphere of each site.
        bounces: number of reflections; each reuses the same rays.
        seed: of the directions.
    """
    rng = np.random.default_rng([seed, 1])
    first = np.unique(model.site, return_index=True)[1]
    position, normal = model.vertices[first], model.normals[first]
    origin = position + OFFSET * normal
    direct = _direct(origin, normal, caster, lighting, rng)
    outside = np.ones(len(first), bool)
    sky = np.zeros_like(origin)
    if lighting.interior is not None:
        x0, y0, x1, y1 = lighting.interior
        outside = (position[:, 0] < x0) | (position[:, 0] > x1) | (position[:, 1] < y0) | (position[:, 1] > y1)
        rooms = np.flatnonzero(~outside)
        sky[rooms] = _through_windows(origin[rooms], normal[rooms], caster, lighting, rng)
    gatherings = [
        _gather(rows, count, origin, normal, caster, rng) for rows, count in _shares(model, first, rays) if len(rows)
    ]
    for part in gatherings:
        sky[part.sites] += part.mean(part.open_sky(lighting.sky)) * outside[part.sites, None]
    ambient = sky
    for _ in range(bounces):
        light = (ambient + direct)[model.site] * model.shade
        ambient = sky.copy()
        for part in gatherings:
            ambient[part.sites] += part.mean(_reflected(model, part, albedo, light))
    at_vertices = _smooth(model, ambient[model.site])
    return BakedLight(at_vertices, at_vertices + direct[model.site])


@dataclass(frozen=True)
class _Gathering:
    """The rays of some sites: ``sites`` ``[s]``, ``directions`` ``[s * rays, 3]``, site by site, and what they meet."""

    sites: npt.NDArray[np.int64]
    directions: Array
    hits: Hits

    def mean(self, radiance: Array) -> Array:
        """Return the mean over each site's rays."""
        return np.asarray(radiance.reshape(len(self.sites), -1, 3).mean(axis=1))

    def open_sky(self, sky: Sky) -> Array:
        """Return the sky's radiance where a ray leaves the scene, else 0."""
        radiance = np.zeros_like(self.directions)
        missed = np.flatnonzero(self.hits.triangle < 0)
        radiance[missed] = sky(self.directions[missed], smooth=False)
        return radiance


def _shares(model: Model, first: npt.NDArray[np.int64], rays: int) -> list[tuple[npt.NDArray[np.int64], int]]:
    """Split the sites: leaves get a quarter of the rays, since nobody sees the grain on a leaf, and they are many."""
    leafy = np.array([m.translucency > 0 or m.texture == "foliage" for m in model.materials])
    material = np.zeros(len(model.vertices), np.int64)
    material[model.triangles] = model.triangle_material[:, None]
    rough = leafy[material[first]]
    return [(np.flatnonzero(~rough), rays), (np.flatnonzero(rough), max(rays // 4, 4))]


def _gather(
    rows: npt.NDArray[np.int64], rays: int, origin: Array, normal: Array, caster: Caster, rng: np.random.Generator
) -> _Gathering:
    directions = _hemispheres(normal[rows], rays, rng).reshape(-1, 3)
    return _Gathering(rows, directions, caster.nearest(np.repeat(origin[rows], rays, axis=0), directions))


def _hemispheres(normal: Array, rays: int, rng: np.random.Generator) -> Array:
    """Return cosine-distributed directions ``[n, rays, 3]``: one golden spiral, turned by chance at each site."""
    k = np.arange(rays) + 0.5
    radius, angle = np.sqrt(k / rays), k * (np.pi * (3 - np.sqrt(5)))
    turn = rng.uniform(0, 2 * np.pi, (len(normal), 1))
    x, y = (radius * np.cos(angle + turn)).astype(np.float32), (radius * np.sin(angle + turn)).astype(np.float32)
    z = np.sqrt(1 - k / rays).astype(np.float32)
    tangent, bitangent = frame(normal)
    return x[..., None] * tangent[:, None] + y[..., None] * bitangent[:, None] + z[:, None] * normal[:, None]


def frame(normal: Array) -> tuple[Array, Array]:
    """Return two unit vectors ``[n, 3]`` that complete ``normal`` to an orthogonal frame (Duff et al. 2017)."""
    x, y, z = normal.T
    sign = np.where(z >= 0, np.float32(1), np.float32(-1))
    a = -1 / (sign + z)
    b = x * y * a
    return np.stack([1 + sign * x * x * a, sign * b, -sign * x], -1), np.stack([b, sign + y * y * a, -y], -1)


def sun_directions(sun: Sun, first: npt.NDArray[np.floating], second: npt.NDArray[np.floating]) -> Array:
    """Return directions ``[n, 3]`` to points of the sun's disc for random numbers ``first`` and ``second`` in 0..1."""
    center = unit(np.asarray(sun.direction, np.float32)[None])
    tangent, bitangent = frame(center)
    radius, angle = sun.angular_radius * np.sqrt(first), 2 * np.pi * second
    return unit(center + (radius * np.cos(angle))[:, None] * tangent + (radius * np.sin(angle))[:, None] * bitangent)


def _direct(origin: Array, normal: Array, caster: Caster, lighting: Lighting, rng: np.random.Generator) -> Array:
    """Return the mean light ``[n, 3]`` of sun and lamps at each site, over four shadow rays each."""
    total = np.zeros_like(origin)
    samples = 4
    for _ in range(samples):
        if lighting.sun is not None:
            toward = sun_directions(lighting.sun, rng.random(len(origin)), rng.random(len(origin)))
            cosine = np.einsum("ij,ij->i", toward, normal)
            lit = np.flatnonzero(cosine > 0)
            lit = lit[~caster.blocked(origin[lit], toward[lit])] if len(lit) else lit
            total[lit] += cosine[lit, None] * np.asarray(lighting.sun.radiance, np.float32)
        for lamp in lighting.lamps:
            goal = np.asarray(lamp.position, np.float32) + lamp.radius * unit(rng.normal(size=origin.shape))
            way = goal - origin
            square = np.maximum(np.einsum("ij,ij->i", way, way), 1e-4)
            cosine = np.einsum("ij,ij->i", way, normal) / np.sqrt(square)
            lit = np.flatnonzero(cosine > 0)
            lit = lit[~caster.blocked(origin[lit], way[lit], 0.999)] if len(lit) else lit
            total[lit] += (cosine / square)[lit, None] * np.asarray(lamp.intensity, np.float32)
    return total / samples


def _through_windows(
    origin: Array, normal: Array, caster: Caster, lighting: Lighting, rng: np.random.Generator
) -> Array:
    """Return the sky's light ``[n, 3]`` through the windows: 3 x 3 stratified points on each, with shadow rays."""
    total = np.zeros_like(origin)
    side = 3
    for window in lighting.windows:
        corner, right, up = (np.asarray(v, np.float32) for v in (window.corner, window.right, window.up))
        inward = np.cross(right, up)
        area = float(np.linalg.norm(inward))
        inward = inward / area
        near = np.flatnonzero(
            ((origin - corner) @ inward > 0)
            & (((corner + (right + up) / 2 - origin) * normal).sum(1) > -np.linalg.norm(right + up) / 2)
        )
        for i, j in np.ndindex(side, side):
            s, t = ((np.array([[i], [j]]) + rng.random((2, len(near)))) / side).astype(np.float32)
            way = corner + s[:, None] * right + t[:, None] * up - origin[near]
            square = np.maximum(np.einsum("ij,ij->i", way, way), 0.01)
            direction = way / np.sqrt(square)[:, None]
            weight = np.einsum("ij,ij->i", direction, normal[near]) * np.maximum(-direction @ inward, 0) / square
            seen = np.flatnonzero(weight > 1e-5)
            if len(seen):
                seen = seen[~caster.blocked(origin[near][seen], way[seen], 1.0)]
                light = lighting.sky(direction[seen]) * (weight[seen] * area / np.pi / side**2)[:, None]
                total[near[seen]] += light.astype(np.float32)
    return total


def _reflected(model: Model, part: _Gathering, albedo: Array, light: Array) -> Array:
    """Return the radiance ``[n, 3]`` that each ray meets, under ``light`` ``[v, 3]`` times the reflectance's shade."""
    radiance = np.zeros_like(part.directions)
    found = np.flatnonzero(part.hits.triangle >= 0)
    triangle = part.hits.triangle[found]
    corners, weights = model.triangles[triangle], part.hits.weights[found]
    material = model.triangle_material[triangle]
    arriving = sum(weights[:, k, None] * light[corners[:, k]] for k in range(3)) * albedo[material]
    emission = np.array([m.emission for m in model.materials], np.float32)[material]
    through = np.array([m.translucency > 0 for m in model.materials])[material]
    # The inside of a solid is dark: a vertex that lies within another object must not glow.
    front = np.einsum("ij,ij->i", part.directions[found], model.normals[corners[:, 0]]) < 0
    radiance[found] = (arriving + emission) * (front | through)[:, None]
    return radiance


def _smooth(model: Model, values: Array) -> Array:
    """Return vertex ``values`` averaged with their neighbours', twice: it takes the grain of the few rays away."""
    from scipy.sparse import coo_matrix

    t = model.triangles
    pairs = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    count = len(values)
    adjacency = coo_matrix((np.ones(len(pairs), np.float32), (pairs[:, 0], pairs[:, 1])), (count, count)).tocsr()
    adjacency.data[:] = 1
    degree = np.maximum(np.asarray(adjacency.sum(axis=1)), 1).astype(np.float32)
    for _ in range(2):
        values = 0.5 * values + 0.5 * (adjacency @ values) / degree
    return np.asarray(values, np.float32)
