"""The light that surfaces receive and pass on, gathered once per vertex.

Each site casts rays over its hemisphere; what they meet passes light on in the next round (Goral et al. 1984, by rays).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix, csr_matrix

from avs.datasets.embedded.geometry.mesh_model import Array, Model
from avs.datasets.embedded.geometry.raycast import Caster
from avs.datasets.embedded.light.light_sources import OFFSET, Lighting, Sky, frame, lamp_directions, sun_directions


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
    direct = _direct(origin, normal, caster, lighting, True, rng)
    outside: npt.NDArray[np.bool_] = np.ones(len(first), bool)
    sky = _direct(origin, normal, caster, lighting, False, rng)
    if lighting.interior is not None:
        low, high = np.reshape(lighting.interior, (2, 2))
        outside = np.any((position[:, :2] < low) | (position[:, :2] > high), axis=1)
        rooms = np.flatnonzero(~outside)
        sky[rooms] += _through_windows(origin[rooms], normal[rooms], caster, lighting, rng)
    shares = [(rows, count) for rows, count in _shares(model, first, rays) if len(rows)]
    gatherings = [_gather(model, rows, count, origin, normal, caster, rng) for rows, count in shares]
    for part in gatherings:
        sky[part.sites] += part.open_sky(lighting.sky) * outside[part.sites, None]
    ambient = sky
    for _ in range(bounces):
        radiance = _outgoing(model, albedo, ambient + direct)
        ambient = sky.copy()
        for part in gatherings:
            ambient[part.sites] += part.gathered(radiance)
    at_vertices = _smooth(model, ambient[model.site])
    return BakedLight(at_vertices, at_vertices + direct[model.site])


@dataclass(frozen=True)
class _Gathering:
    """The rays of some sites: ``sites`` ``[s]``, ``directions`` ``[s * rays, 3]`` site by site.

    ``source`` ``[s * rays]`` is the triangle that a ray meets; -1 is darkness, -2 the sky.
    """

    sites: npt.NDArray[np.int64]
    directions: Array
    source: npt.NDArray[np.int64]

    def gathered(self, radiance: Array) -> Array:
        """Return the mean over each site's rays of the ``radiance`` ``[t, 3]`` of the triangles that they meet."""
        rays = len(self.source) // len(self.sites)
        start = np.arange(0, len(self.source) + 1, rays)
        weights = (self.source >= 0).astype(np.float32) / np.float32(rays)
        # A product with a sparse matrix sums in a fixed order, several times faster than a mean over the middle axis.
        matrix = csr_matrix((weights, np.maximum(self.source, 0), start), (len(self.sites), len(radiance)))
        return np.asarray(matrix @ radiance, np.float32)

    def open_sky(self, sky: Sky) -> Array:
        """Return the mean over each site's rays of the sky's radiance, where they leave the scene."""
        rays = len(self.source) // len(self.sites)
        missed = np.flatnonzero(self.source == -2)
        total = np.zeros((len(self.sites), 3))
        light, site = sky(self.directions[missed], smooth=False), missed // rays
        for channel in range(3):
            total[:, channel] = np.bincount(site, light[:, channel], len(self.sites))
        return np.asarray(total / rays, np.float32)


def _shares(model: Model, first: npt.NDArray[np.int64], rays: int) -> list[tuple[npt.NDArray[np.int64], int]]:
    """Split the sites: leaves get a quarter of the rays, since nobody sees the grain on a leaf, and they are many."""
    leafy = np.array([m.translucency > 0 or m.texture == "foliage" for m in model.materials])
    material = np.zeros(len(model.vertices), np.int64)
    material[model.triangles] = model.triangle_material[:, None]
    rough = leafy[material[first]]
    return [(np.flatnonzero(~rough), rays), (np.flatnonzero(rough), max(rays // 4, 4))]


def _gather(
    model: Model,
    rows: npt.NDArray[np.int64],
    rays: int,
    origin: Array,
    normal: Array,
    caster: Caster,
    rng: np.random.Generator,
) -> _Gathering:
    directions = _hemispheres(normal[rows], rays, rng).reshape(-1, 3)
    source = caster.first_triangles(np.repeat(origin[rows], rays, axis=0), directions)
    triangle = np.maximum(source, 0)
    through = np.array([m.translucency > 0 for m in model.materials])[model.triangle_material[triangle]]
    # The inside of a solid is dark: a vertex that lies within another object must not glow.
    front = np.einsum("ij,ij->i", directions, model.normals[model.triangles[triangle, 0]]) < 0
    return _Gathering(rows, directions, np.where(source < 0, -2, np.where(front | through, source, -1)))


def _hemispheres(normal: Array, rays: int, rng: np.random.Generator) -> Array:
    """Return cosine-distributed directions ``[n, rays, 3]``: one golden spiral, turned by chance at each site."""
    k = np.arange(rays) + 0.5
    radius, angle = np.sqrt(k / rays), k * (np.pi * (3 - np.sqrt(5)))
    spiral = np.stack([radius * np.cos(angle), radius * np.sin(angle)]).astype(np.float32)
    turn = rng.uniform(0, 2 * np.pi, (len(normal), 1))
    cosine, sine = np.cos(turn).astype(np.float32), np.sin(turn).astype(np.float32)
    x, y = spiral[0] * cosine - spiral[1] * sine, spiral[0] * sine + spiral[1] * cosine
    z = np.sqrt(1 - k / rays).astype(np.float32)
    tangent, bitangent = frame(normal)
    turned = x[..., None] * tangent[:, None] + y[..., None] * bitangent[:, None]
    return np.asarray(turned + z[:, None] * normal[:, None])


def _direct(
    origin: Array, normal: Array, caster: Caster, lighting: Lighting, sharp: bool, rng: np.random.Generator
) -> Array:
    """Return the mean light ``[n, 3]`` of sun and ``sharp`` lamps, or of the other lamps, over four shadow rays."""
    total = np.zeros_like(origin)
    samples = 4
    lamps = [lamp for lamp in lighting.lamps if lamp.sharp == sharp]
    for _ in range(samples):
        draws = rng.random((len(origin), 2), dtype=np.float32)
        if lighting.sun is not None and sharp:
            toward = sun_directions(lighting.sun, draws)
            cosine = np.einsum("ij,ij->i", toward, normal)
            lit = np.flatnonzero(cosine > 0)
            lit = lit[~caster.blocked(origin[lit], toward[lit])]
            total[lit] += cosine[lit, None] * np.asarray(lighting.sun.radiance, np.float32)
        for lamp in lamps:
            way = lamp_directions(lamp, origin, draws)
            square = np.maximum(np.einsum("ij,ij->i", way, way), 1e-4)
            weight = np.einsum("ij,ij->i", way, normal) / square**1.5
            lit = np.flatnonzero(weight * max(lamp.intensity) > 2e-3)
            lit = lit[~caster.blocked(origin[lit], way[lit], 0.999)]
            total[lit] += weight[lit, None] * np.asarray(lamp.intensity, np.float32)
    return np.asarray(total / samples, np.float32)


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
        way = corner + (right + up) / 2 - origin
        distance = np.linalg.norm(way, axis=1)
        front = (np.einsum("ij,ij->i", way, normal) > -float(np.linalg.norm(right + up)) / 2) & (way @ inward < 0)
        # A window that covers less than 0.1 % of the hemisphere is not worth its rays.
        near = np.flatnonzero(front & (np.abs(way @ inward) * area / np.pi > 1e-3 * distance**3))
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


def _outgoing(model: Model, albedo: Array, light: Array) -> Array:
    """Return the radiance ``[t, 3]`` of each triangle under site ``light`` ``[s, 3]``."""
    shaded = light[model.site] * model.shade
    mean = (shaded[model.triangles[:, 0]] + shaded[model.triangles[:, 1]] + shaded[model.triangles[:, 2]]) * np.float32(
        1 / 3
    )
    emission = np.array([m.emission for m in model.materials], np.float32)
    return np.asarray(mean * albedo[model.triangle_material] + emission[model.triangle_material], np.float32)


def _smooth(model: Model, values: Array) -> Array:
    """Return vertex ``values`` averaged with their neighbours', twice: it takes the grain of the few rays away."""
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
