"""The radiance that each ray brings back: sun and lamps with shadows, baked light, reflections, haze."""

from __future__ import annotations

import numpy as np

from avs.datasets.embedded.embedded_settings import EmbeddedSettings
from avs.datasets.embedded.geometry.mesh_model import Array, Model, unit
from avs.datasets.embedded.geometry.raycast import Caster, Hits
from avs.datasets.embedded.light.baking import bake
from avs.datasets.embedded.light.light_sources import OFFSET, Lighting, lamp_directions, sun_directions
from avs.datasets.embedded.materials.atlas import Atlas

# Rays that are shaded together: few enough that their arrays stay in the processor's cache.
_CHUNK = 1 << 13
# Below this roughness a surface mirrors its surroundings by rays of its own; above it, it reflects the sky's gradient.
_MIRROR = 0.3
# Highlights stay below this multiple of the light: a camera's sensor clips, and single bright samples would flicker.
_HIGHLIGHT = 6.0


class Shader:
    """A model with textures and baked light, ready to answer rays."""

    def __init__(self, model: Model, lighting: Lighting, settings: EmbeddedSettings, seed: int) -> None:
        """Build the search structure, the textures (varied by ``seed``) and the baked light."""
        self.model, self.lighting = model, lighting
        self.caster = Caster(model.vertices, model.triangles)
        self.atlas = Atlas(model.textures, settings.texture_levels, seed)
        layers = {name: index for index, name in enumerate(self.atlas.names)}
        materials = model.materials
        self._layer = np.array([layers[m.texture] for m in materials])
        self._tint = np.array([m.tint for m in materials], np.float32)
        self._emission = np.array([m.emission for m in materials], np.float32)
        # size, roughness, reflectance, relief / size, translucency
        self._numbers = np.array(
            [(m.size, m.roughness, m.reflectance, m.relief / m.size, m.translucency) for m in materials], np.float32
        )
        self._albedo = self.atlas.means[self._layer] * self._tint
        self.light = bake(model, self.caster, lighting, self._albedo, settings.gather_rays, settings.bounces, seed)
        self._vertex = np.concatenate([model.normals, model.coordinates, model.shade, self.light.ambient], axis=1)
        self._frames = _triangle_frames(model)
        self.face_normals = self._frames[:, :3]
        self._open_sky = float(lighting.sky.panorama[:64].mean())

    def radiance(self, origins: Array, directions: Array, footprint: float, draws: Array) -> Array:
        """Return the radiance ``[n, 3]`` along unit ``directions`` from ``origins`` ``[n, 3]``.

        Args:
            origins: starts of the rays.
            directions: of unit length.
            footprint: angle in radians that one ray stands for.
            draws: ``[n, 3]`` random numbers in 0..1: two for points on sun and lamps, one for the level of detail.
        """
        color = np.empty_like(directions)
        for start in range(0, len(directions), _CHUNK):
            part = slice(start, start + _CHUNK)
            color[part] = self._radiance(origins[part], directions[part], footprint, draws[part])
        return color

    def _radiance(self, origins: Array, directions: Array, footprint: float, draws: Array) -> Array:
        hits = self.caster.nearest(origins, directions)
        color = np.empty_like(directions)
        found = np.flatnonzero(hits.triangle >= 0)
        missed = np.flatnonzero(hits.triangle < 0)
        color[missed] = self.lighting.sky(directions[missed])
        if len(found):
            part = Hits(hits.distance[found], hits.triangle[found], hits.weights[found])
            color[found] = self.shade(origins[found], directions[found], part, footprint, draws[found])
        return color

    def shade(self, origins: Array, directions: Array, hits: Hits, footprint: float, draws: Array) -> Array:
        """Return the radiance ``[n, 3]`` of the surfaces at ``hits``, which all exist; see ``radiance``."""
        material = self.model.triangle_material[hits.triangle]
        size, roughness, reflectance, relief, translucency = self._numbers[material].T
        corners = self.model.triangles[hits.triangle]
        fields = sum(hits.weights[:, k, None] * self._vertex[corners[:, k]] for k in range(3))
        assert isinstance(fields, np.ndarray)
        frames = self._frames[hits.triangle]
        face, tangent, bitangent = frames[:, :3], frames[:, 3:6], frames[:, 6:]
        facing = -np.einsum("ij,ij->i", directions, face)
        side = np.where(facing < 0, np.float32(-1), np.float32(1))
        slant = np.maximum(np.abs(facing), 0.05)
        level = np.log2(np.maximum(hits.distance * footprint / np.sqrt(slant) / size, 1e-9)) + self.atlas.levels
        level += draws[:, 2] - np.float32(0.5)
        surface = self.atlas.lookup(self._layer[material], fields[:, 3:5] / size[:, None], level)
        normal = fields[:, :3] * side[:, None]
        slope = surface.slope * relief[:, None]
        normal = unit(normal - slope[:, :1] * tangent - slope[:, 1:] * bitangent)
        albedo = surface.color * self._tint[material] * fields[:, 5:8]
        ambient = fields[:, 8:11]
        point = origins + directions * hits.distance[:, None] + (np.float32(OFFSET) * side)[:, None] * face
        shine = reflectance * surface.gloss
        diffuse, highlight = self._direct(point, normal, directions, roughness, translucency, draws)
        cosine = np.clip(-np.einsum("ij,ij->i", directions, normal), 0.02, 1)
        fresnel = (shine + np.maximum(surface.gloss - roughness, 0) * (1 - shine) * (1 - cosine) ** 5)[:, None]
        mirrored = self._mirrored(point, normal, directions, roughness, ambient)
        strength = shine[:, None]
        color = albedo * (diffuse + ambient) * (1 - fresnel) + highlight * strength + mirrored * fresnel
        color = color + self._emission[material]
        if self.lighting.haze:
            clear = np.exp(-self.lighting.haze * hits.distance)[:, None]
            color = color * clear + self.lighting.sky.panorama[60].mean(axis=0) * (1 - clear)
        return np.asarray(color, np.float32)

    def _direct(
        self,
        point: Array,
        normal: Array,
        directions: Array,
        roughness: Array,
        translucency: Array,
        draws: Array,
    ) -> tuple[Array, Array]:
        """Return the diffuse light and the strength of the highlight, both ``[n, 3]``, of sun and lamps."""
        diffuse, highlight = np.zeros_like(point), np.zeros_like(point)
        lights: list[tuple[Array, Array, float]] = []
        if self.lighting.sun is not None:
            toward = sun_directions(self.lighting.sun, draws)
            power = np.broadcast_to(np.asarray(self.lighting.sun.radiance, np.float32), point.shape)
            lights.append((toward, power, np.inf))
        for lamp in self.lighting.lamps:
            if lamp.sharp:
                way = lamp_directions(lamp, point, draws)
                square = np.maximum(np.einsum("ij,ij->i", way, way), 1e-3)
                lights.append((way, np.asarray(lamp.intensity, np.float32) / square[:, None], 0.999))
        for way, power, far in lights:
            toward = way if np.isinf(far) else unit(way)
            cosine = np.einsum("ij,ij->i", toward, normal)
            weight = np.where(cosine > 0, cosine, -cosine * translucency)
            lit = np.flatnonzero(weight > 1e-3)
            if not len(lit):
                continue
            lit = lit[~self.caster.blocked(point[lit], way[lit], far)]
            diffuse[lit] += power[lit] * weight[lit, None]
            strength = _ggx(normal[lit], toward[lit], -directions[lit], roughness[lit]) * np.maximum(cosine[lit], 0)
            highlight[lit] += power[lit] * np.minimum(strength, _HIGHLIGHT / 0.04)[:, None]
        return diffuse, highlight

    def _mirrored(self, point: Array, normal: Array, directions: Array, roughness: Array, ambient: Array) -> Array:
        """Return the radiance ``[n, 3]`` that arrives from the mirrored direction."""
        reflected = directions - 2 * np.einsum("ij,ij->i", directions, normal)[:, None] * normal
        mirrored = np.array(ambient)
        if self.lighting.interior is None:
            # Where little light of the sky arrives, little of it can be mirrored.
            opening = np.clip(ambient.mean(axis=1) / self._open_sky, 0, 1)[:, None]
            mirrored = self.lighting.sky.blurred(reflected[:, 2]) * opening * np.float32(0.7) + ambient * np.float32(
                0.3
            )
        polished = np.flatnonzero(roughness < _MIRROR)
        if len(polished):
            hits = self.caster.nearest(point[polished], reflected[polished])
            color = self.lighting.sky(reflected[polished])
            found = np.flatnonzero(hits.triangle >= 0)
            corners = self.model.triangles[hits.triangle[found]]
            light = np.einsum("nk,nkc->nc", hits.weights[found], (self.light.total * self.model.shade)[corners])
            material = self.model.triangle_material[hits.triangle[found]]
            color[found] = light * self._albedo[material] + self._emission[material]
            mirrored[polished] = color
        return mirrored


def _ggx(normal: Array, toward: Array, view: Array, roughness: Array) -> Array:
    """Return pi times GGX distribution and Smith's visibility (Walter et al. 2007, Karis 2013), per reflectance."""
    half = unit(toward + view)
    alpha = np.maximum(roughness, 0.08) ** 2
    square = alpha * alpha
    nh = np.clip(np.einsum("ij,ij->i", normal, half), 0, 1)
    nl = np.clip(np.einsum("ij,ij->i", normal, toward), 1e-3, 1)
    nv = np.clip(np.einsum("ij,ij->i", normal, view), 1e-3, 1)
    distribution = square / (nh * nh * (square - 1) + 1) ** 2
    k = (roughness + 1) ** 2 / 8
    visibility = 1 / (4 * (nl * (1 - k) + k) * (nv * (1 - k) + k))
    return np.asarray(distribution * visibility, np.float32)


def _triangle_frames(model: Model) -> Array:
    """Return ``[t, 9]``: unit normal, and the unit directions in which each texture coordinate grows."""
    a, b, c = (model.vertices[model.triangles[:, k]] for k in range(3))
    u, v, w = (model.coordinates[model.triangles[:, k]] for k in range(3))
    first, second = b - a, c - a
    s, t = v - u, w - u
    determinant = s[:, 0] * t[:, 1] - s[:, 1] * t[:, 0]
    sign = np.where(determinant < 0, -1.0, 1.0)[:, None]
    tangent = (first * t[:, 1:] - second * s[:, 1:]) * sign
    bitangent = (second * s[:, :1] - first * t[:, :1]) * sign
    return np.concatenate([unit(np.cross(first, second)), unit(tangent), unit(bitangent)], axis=1)
