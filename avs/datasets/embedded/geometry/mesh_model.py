"""Meshes with one material each, and the scene that they are put together to."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float32]
Color = tuple[float, float, float]


@dataclass(frozen=True)
class Material:
    """How a surface looks.

    Attributes:
        texture: name of a texture, see ``textures``.
        size: metres that one repeat of the texture covers; a picture covers its ``size`` once.
        tint: factor on the texture's reflectance.
        roughness: of the GGX reflection, 0.05 (polished) to 1.
        reflectance: reflection at normal incidence: 0.04 for plastic, wood, stone; 0.5 and more for metal.
        relief: height of the texture's relief in metres.
        translucency: share of light that passes through, for leaves.
        emission: radiance that the surface sends out by itself.
    """

    texture: str
    size: float = 1.0
    tint: Color = (1.0, 1.0, 1.0)
    roughness: float = 0.6
    reflectance: float = 0.04
    relief: float = 0.0
    translucency: float = 0.0
    emission: Color = (0.0, 0.0, 0.0)

    def tinted(self, *tint: float) -> Material:
        """Return this material under another tint."""
        return replace(self, tint=(tint[0], tint[1], tint[2]))


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh of one material.

    Attributes:
        vertices: ``[v, 3]`` metres, z upwards.
        normals: ``[v, 3]`` unit length.
        coordinates: ``[v, 2]`` texture coordinates, in metres along the surface.
        triangles: ``[t, 3]`` vertex indices.
        material: of all triangles.
        shade: ``[v, 3]`` factor on the reflectance.
        site: ``[v]`` index of the place where the vertex' light is computed: most often the vertex itself; the
            vertices of a leaf share one.
    """

    vertices: Array
    normals: Array
    coordinates: Array
    triangles: npt.NDArray[np.int32]
    material: Material
    shade: Array = field(default_factory=lambda: np.empty((0, 3), np.float32))
    site: npt.NDArray[np.int32] = field(default_factory=lambda: np.empty(0, np.int32))

    def __post_init__(self) -> None:
        """Fill in the defaults of ``shade`` (ones) and ``site`` (each vertex its own)."""
        if not len(self.shade):
            object.__setattr__(self, "shade", np.ones((len(self.vertices), 3), np.float32))
        if not len(self.site):
            object.__setattr__(self, "site", np.arange(len(self.vertices), dtype=np.int32))

    def moved(self, x: float, y: float, z: float) -> Mesh:
        """Return the mesh moved by metres along the axes."""
        return replace(self, vertices=self.vertices + np.array([x, y, z], np.float32))

    def turned(self, angle: float, axis: str = "z") -> Mesh:
        """Return the mesh turned by ``angle`` in radians about a coordinate axis through the origin."""
        rotation = rotation_about(angle, axis)
        return replace(self, vertices=self.vertices @ rotation.T, normals=self.normals @ rotation.T)

    def scaled(self, x: float, y: float, z: float) -> Mesh:
        """Return the mesh scaled along the axes; texture coordinates stay."""
        factor = np.array([x, y, z], np.float32)
        normals = self.normals / factor
        return replace(self, vertices=self.vertices * factor, normals=unit(normals))

    def clothed(self, material: Material) -> Mesh:
        """Return the mesh in another material."""
        return replace(self, material=material)

    def shaded(self, shade: npt.NDArray[np.floating]) -> Mesh:
        """Return the mesh with the factor ``[v, 3]`` (or what broadcasts to it) on its reflectance."""
        return replace(self, shade=np.broadcast_to(shade, self.vertices.shape).astype(np.float32))

    def shifted(self, rng: np.random.Generator) -> Mesh:
        """Return the mesh with its texture moved by chance, so that equal pieces do not look the same."""
        return replace(self, coordinates=self.coordinates + rng.random(2, dtype=np.float32) * self.material.size)


Group = list[Mesh]


def moved(group: Iterable[Mesh], x: float, y: float, z: float) -> Group:
    """Return all meshes of ``group`` moved."""
    return [mesh.moved(x, y, z) for mesh in group]


def turned(group: Iterable[Mesh], angle: float, axis: str = "z") -> Group:
    """Return all meshes of ``group`` turned about a coordinate axis."""
    return [mesh.turned(angle, axis) for mesh in group]


def scaled(group: Iterable[Mesh], factor: float) -> Group:
    """Return all meshes of ``group`` scaled in all directions."""
    return [mesh.scaled(factor, factor, factor) for mesh in group]


def rotation_about(angle: float, axis: str) -> Array:
    """Return the ``[3, 3]`` rotation by ``angle`` about ``axis`` (x, y or z), right-handed."""
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3, dtype=np.float32)
    matrix[first, first] = matrix[second, second] = np.cos(angle)
    matrix[second, first] = np.sin(angle)
    matrix[first, second] = -np.sin(angle)
    return matrix


def unit(vectors: npt.NDArray[np.floating]) -> Array:
    """Return ``vectors`` ``[..., 3]`` at length one; a zero vector stays zero."""
    length = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))[..., None]
    return np.asarray(vectors / np.maximum(length, 1e-12), np.float32)


@dataclass(frozen=True)
class Model:
    """All meshes of a scene in shared arrays.

    Attributes:
        vertices, normals, coordinates, shade, site: as in ``Mesh``, concatenated; sites are counted over the scene.
        triangles: ``[t, 3]`` int32.
        triangle_material: ``[t]`` int32, index into ``materials``.
        materials: the distinct materials.
    """

    vertices: Array
    normals: Array
    coordinates: Array
    shade: Array
    site: npt.NDArray[np.int32]
    triangles: npt.NDArray[np.int32]
    triangle_material: npt.NDArray[np.int32]
    materials: tuple[Material, ...]

    @property
    def textures(self) -> tuple[str, ...]:
        """Names of the textures in use, ascending."""
        return tuple(sorted({material.texture for material in self.materials}))


def assemble(meshes: Iterable[Mesh]) -> Model:
    """Put ``meshes`` together, in order."""
    parts = list(meshes)
    materials = list(dict.fromkeys(mesh.material for mesh in parts))
    index = {material: i for i, material in enumerate(materials)}
    vertex_start = np.cumsum([0] + [len(mesh.vertices) for mesh in parts])
    site_start = np.cumsum([0] + [int(mesh.site.max(initial=-1)) + 1 for mesh in parts])
    return Model(
        vertices=np.concatenate([mesh.vertices for mesh in parts]).astype(np.float32),
        normals=np.concatenate([mesh.normals for mesh in parts]).astype(np.float32),
        coordinates=np.concatenate([mesh.coordinates for mesh in parts]).astype(np.float32),
        shade=np.concatenate([mesh.shade for mesh in parts]).astype(np.float32),
        site=np.concatenate([mesh.site + start for mesh, start in zip(parts, site_start, strict=False)]).astype(
            np.int32
        ),
        triangles=np.concatenate(
            [mesh.triangles + start for mesh, start in zip(parts, vertex_start, strict=False)]
        ).astype(np.int32),
        triangle_material=np.concatenate(
            [np.full(len(mesh.triangles), index[mesh.material], np.int32) for mesh in parts]
        ),
        materials=tuple(materials),
    )
