"""From a pattern and a seed to a complete capture: photographs, cameras, split, sparse points, depth and mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.apartment import ply_bytes
from avs.datasets.embedded.camera import trajectories
from avs.datasets.embedded.camera.film import develop
from avs.datasets.embedded.camera.lens import Lens
from avs.datasets.embedded.camera.render import depth, meter, render
from avs.datasets.embedded.camera.surface_points import sparse_points
from avs.datasets.embedded.embedded_settings import EmbeddedSettings
from avs.datasets.embedded.geometry.mesh_model import Array, Model, assemble
from avs.datasets.embedded.geometry.raycast import Caster
from avs.datasets.embedded.layouts import house, indoor, outdoor
from avs.datasets.embedded.layouts.stage import Stage
from avs.datasets.embedded.light.shading import Shader
from avs.scene.cameras import Cameras, IndexArray
from avs.scene.scene import Points, write_scene
from avs.system.errors import UserError
from avs.system.files import temporary_folder

Generator = np.random.Generator


@dataclass(frozen=True)
class Pattern:
    """How one data set of the literature is imitated.

    Attributes:
        number: part of every seed, so that patterns of equal seeds share nothing.
        layout: builds the scene; it gets the scene's seed and a generator.
        path: places the cameras.
        lens: of all images.
    """

    number: int
    layout: Callable[[int, Generator], Stage]
    path: Callable[[Stage, int, Caster, Generator], npt.NDArray[np.float64]]
    lens: Lens


def _orbit_stage(seed: int, rng: Generator) -> Stage:
    return indoor.dining_room(rng) if seed % 2 else outdoor.garden(rng)


def _handheld_stage(seed: int, rng: Generator) -> Stage:
    return outdoor.facade(rng) if seed % 2 else outdoor.sculpture_court(rng)


PATTERNS: dict[str, Pattern] = {
    "orbit": Pattern(1, _orbit_stage, trajectories.orbit, Lens(1.5, 62)),
    "walkthrough": Pattern(2, lambda _, rng: house.walk_stage(rng), trajectories.walkthrough, Lens(16 / 9, 72)),
    "handheld": Pattern(3, _handheld_stage, trajectories.handheld, Lens(9 / 16, 65, exposure_jitter=0.12)),
    "egocentric": Pattern(
        4, lambda _, rng: indoor.showroom(rng), trajectories.egocentric, Lens(1.0, 95, 0.55, 0.04, vignette=0.55)
    ),
}


@dataclass(frozen=True)
class Capture:
    """Everything that a scene folder holds.

    Attributes:
        names: image file names, ascending.
        images: sRGB photographs, uint8.
        cameras: of the images.
        test: indices of the test images.
        points: as structure from motion would find them.
        depth: ``[height, width]`` float32 metres along the optical axis per image; 0 where there is no surface.
        mesh: vertices ``[v, 3]`` and triangles ``[t, 3]`` of all surfaces.
    """

    names: tuple[str, ...]
    images: tuple[npt.NDArray[np.uint8], ...]
    cameras: Cameras
    test: IndexArray
    points: Points
    depth: tuple[Array, ...]
    mesh: Model


def build_capture(pattern: str, seed: int, settings: EmbeddedSettings) -> Capture:
    """Return the capture of ``pattern``, a key of ``PATTERNS``, that ``seed`` draws; equal arguments, equal bytes.

    Raises:
        UserError: there is no such pattern.
    """
    if pattern not in PATTERNS:
        raise UserError(f"pattern {pattern!r}", "unknown", f"choose one of {', '.join(sorted(PATTERNS))}")
    kind = PATTERNS[pattern]
    stage = kind.layout(seed, np.random.default_rng([seed, kind.number, 0]))
    model = assemble(stage.meshes)
    shader = Shader(model, stage.lighting, settings, seed)
    poses = kind.path(stage, settings.views, shader.caster, np.random.default_rng([seed, kind.number, 1]))
    cameras = kind.lens.cameras(poses, settings.long_side)
    exposure = meter(shader, cameras, np.random.default_rng([seed, kind.number, 5]))
    linear = [
        render(
            shader,
            cameras,
            index,
            settings.samples_per_axis,
            exposure,
            np.random.default_rng([seed, kind.number, 2, index]),
        )
        for index in range(len(cameras))
    ]
    images = develop(linear, exposure, kind.lens, np.random.default_rng([seed, kind.number, 3]))
    depths = tuple(depth(shader, cameras, index) for index in range(len(cameras)))
    test = np.arange(0, len(cameras), 8)
    pool = np.setdiff1d(np.arange(len(cameras)), test)
    points = sparse_points(
        shader.caster, cameras, images, depths, pool, settings, np.random.default_rng([seed, kind.number, 4])
    )
    names = tuple(f"{index:04d}.png" for index in range(len(cameras)))
    return Capture(names, images, cameras, test, points, depths, model)


def write_capture(capture: Capture, pattern: str, seed: int, folder: Path, dataset: str | None = None) -> None:
    """Write ``capture``, which ``pattern`` and ``seed`` gave, as a scene of ``dataset``, by default ``pattern``."""
    with temporary_folder("avs-scene-") as temporary:
        mesh = temporary / "mesh.ply"
        mesh.write_bytes(ply_bytes(capture.mesh.vertices, capture.mesh.triangles))
        write_scene(
            folder,
            name=f"{pattern}_{seed}",
            dataset=dataset or pattern,
            names=capture.names,
            images=capture.images,
            cameras=capture.cameras,
            test=capture.test,
            points=capture.points,
            source=f"synthetic, avs.datasets.embedded, seed {seed}; textures partly photographs from scikit-image",
            licence="CC0 1.0; the photographs are in the public domain or CC0",
            depth=capture.depth,
            mesh=mesh,
        )
