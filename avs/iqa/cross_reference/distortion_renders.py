"""Making of distortion data: a training scene is reconstructed step by step, and rendered on the way."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from avs.iqa.cross_reference.distortions import CodedMap, Distortions, Image, Moment, coded, write_distortions
from avs.iqa.cross_reference.scorer_settings import RenderJob, RenderSettings
from avs.iqa.render_statistics.view_geometry import VIEW_GEOMETRY, FloatArray, view_geometry
from avs.representations import kinds
from avs.representations.base import Representation
from avs.scene.cameras import Cameras, IndexArray
from avs.scene.photographs import Photographs
from avs.scene.sampling import initial_views
from avs.scene.scene import Scene, read_scene
from avs.selection.session import Session
from avs.system.devices import take_device
from avs.system.errors import UserError
from metrics.image import ssim_map

_INITIAL_VIEWS = 4

SeededBuilder = Callable[[IndexArray, int], Representation]
"""Makes an untrained representation, given the indices of the first captured views and a seed."""

Progress = Callable[[str], None]
"""Takes one line about each step."""


def make_renders(scene_folder: Path, out: Path, job: RenderJob, seed: int, progress: Progress) -> None:
    """Reconstruct the scene in ``scene_folder`` and write its distortion data to ``out``.

    Raises:
        UserError: the scene is damaged or has too few views.
    """
    take_device(job.device)
    scene = read_scene(scene_folder)

    def builder(captured: IndexArray, run_seed: int) -> Representation:
        return kinds.build(scene, captured, job.representation, run_seed, job.device)

    write_distortions(out, collect(scene, builder, job.renders, seed, progress))


def collect(scene: Scene, build: SeededBuilder, settings: RenderSettings, seed: int, progress: Progress) -> Distortions:
    """Reconstruct ``scene`` once per run and keep renderings with their SSIM maps.

    Every image of the scene can be captured, its test images too: nothing is evaluated on this scene. At each moment
    captured and other views are rendered, in the order of the scene. Moments that would leave no view uncaptured are
    left out, with a line. Knows no representation by name.

    Raises:
        UserError: the scene has no view beyond the first moment's captured ones, or an image is damaged.
    """
    count = len(scene.names)
    settings = _with_views_left(settings, scene.name, count, progress)
    decoded = Photographs(scene)
    photographs = decoded.views(np.arange(count))
    moments: list[Moment] = []
    renderings: list[Image] = []
    maps: list[CodedMap] = []
    images: list[int] = []
    moment_of: list[int] = []
    geometry: list[FloatArray] = []
    for run in range(settings.runs):
        for moment, representation, shown in _moments(decoded, scene, build, settings, seed, run):
            captured = photographs.cameras[list(moment.captured)]
            rendered, known = _rendered(representation, photographs.cameras[shown], captured)
            similarity = [ssim_map(image, photographs.images[i]) for image, i in zip(rendered, shown, strict=True)]
            renderings += rendered
            maps += [coded(values) for values in similarity]
            images += shown.tolist()
            moment_of += [len(moments)] * len(shown)
            moments.append(moment)
            geometry.append(known)
            state = f"{len(moment.captured)} views, {moment.iteration} steps, SSIM {np.mean(similarity):.3f}"
            progress(f"{scene.name}, run {run + 1} of {settings.runs}: {state}")
    return Distortions(
        scene=scene.name,
        scene_hash=scene.content_hash,
        photographs=photographs.images,
        moments=tuple(moments),
        renderings=tuple(renderings),
        maps=tuple(maps),
        images=tuple(images),
        moment_of=tuple(moment_of),
        geometry=np.concatenate(geometry),
        centers=photographs.cameras.centers,
    )


def _with_views_left(settings: RenderSettings, name: str, count: int, progress: Progress) -> RenderSettings:
    """Return ``settings`` with the moments at which fewer than all ``count`` images of a scene are captured."""
    kept = sum(views < count for views in settings.views)  # they ascend
    if not kept:
        fault = f"has {count} images, of which {settings.views[0]} are captured at the first moment"
        raise UserError(f"scene {name}", fault, "add images, or lower renders.views")
    if kept < len(settings.views):
        progress(f"{name}: {count} images, so that {kept} of {len(settings.views)} moments leave a view uncaptured")
    return settings.model_copy(update={"views": settings.views[:kept], "iterations": settings.iterations[:kept]})


def _moments(
    photographs: Photographs, scene: Scene, build: SeededBuilder, settings: RenderSettings, seed: int, run: int
) -> Iterator[tuple[Moment, Representation, IndexArray]]:
    """Yield the states of one reconstruction, and which images are to be rendered then, ascending."""
    rng = np.random.default_rng([seed, run])
    order = _capture_order(scene, rng)
    run_seed = int(rng.integers(2**63))
    first = order[: settings.views[0]]
    session = Session(scene, lambda captured: build(captured, run_seed), first, photographs=photographs)
    for views, iteration in zip(settings.views, settings.iterations, strict=True):
        session.capture(order[len(session.captured) : views])
        session.fit_until(iteration)
        shown = np.sort(rng.permutation(len(order))[: settings.cameras])
        yield Moment(run=run, iteration=iteration, captured=tuple(session.captured)), session.representation, shown


def _capture_order(scene: Scene, rng: np.random.Generator) -> IndexArray:
    """Return all images: as an episode begins, four by farthest-view sampling from a random one on; then at random."""
    count = len(scene.names)
    first = initial_views(scene.cameras.centers, min(_INITIAL_VIEWS, count), int(rng.integers(count)))
    return np.concatenate([first, rng.permutation(np.setdiff1d(np.arange(count), first))])


def _rendered(representation: Representation, cameras: Cameras, captured: Cameras) -> tuple[list[Image], FloatArray]:
    """Return the 8-bit renderings of ``cameras``, in their order, and what is known of these views beside."""
    found: dict[int, Image] = {}
    geometry = np.empty((len(cameras), len(VIEW_GEOMETRY)))
    for _, rows in cameras.by_size():
        rendering = representation.render(cameras[rows])
        geometry[rows] = view_geometry(rendering, cameras[rows], captured)
        for row, rgb in zip(rows.tolist(), rendering.rgb, strict=True):
            found[row] = np.round(np.clip(rgb, 0.0, 1.0) * 255.0).astype(np.uint8)
    return [found[row] for row in range(len(cameras))], geometry
