"""The coverage of one episode: the cloud of its views, held against the scene's reference."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from avs.coverage.clouds_of_views import PlacedCloud, Stopwatch, cloud_of, why_empty
from avs.coverage.coverage_record import Coverage, CoveragePoint
from avs.coverage.coverage_settings import CoverageJob
from avs.coverage.reference_cloud import ReferenceFiles, read_reference
from avs.coverage.two_clouds import Distances, Side, held_against, numbers, share_covered, sides_of
from avs.nvs.record import Episode
from avs.scene.scene import Scene, read_scene
from avs.sfm.cloud_file import write_cloud
from avs.system.devices import take_device
from avs.system.errors import UserError
from avs.system.records import read_record, write_record

RECORD, META, CLOUD, COVERED, SURFACE = (
    "coverage.json",
    "coverage.meta.json",
    "cloud.ply",
    "covered.ply",
    "covered_surface.ply",
)
"""What the job writes to its folder."""

DISTANCE, TRUE_DISTANCE = "distance", "true_distance"
"""Fields of clouds: the distance to the nearest point of the other cloud, and of the true surface, in scene units.

``cloud.ply`` has those of its points to the reference and the surface; ``covered.ply`` has the reference's points, one
for each voxel, and ``covered_surface.ply`` the surface's, each with the distance to the episode's cloud.
"""


def write_coverage(
    scene_folder: Path,
    episode: Path,
    reference_folder: Path,
    settings: CoverageJob,
    out: Path,
    progress: Callable[[str], None],
) -> None:
    """Measure the coverage of an episode's views and write its record, its facts of the run and clouds to ``out``.

    Views that do not register are a result: a cloud without points covers nothing.

    Args:
        scene_folder: the scene of the episode.
        episode: its ``episode.json``.
        reference_folder: what ``avs.coverage.reference_cloud.write_reference`` wrote.
        settings: the back end and what is measured.
        out: folder of the results.
        progress: receives one line about each cloud.

    Raises:
        UserError: a file is missing, damaged, or of another version of the scene; or the back end cannot run here.
    """
    take_device(settings.device)
    watch, scene = Stopwatch(settings.device), read_scene(scene_folder)
    recorded = read_record(episode, Episode)
    _check_episode(episode, recorded, scene)
    reference = read_reference(reference_folder, scene)
    if settings.sfm.model_dump(mode="json") != reference.record.settings["sfm"]:
        raise UserError(reference_folder, "was made with other settings of structure from motion", "make it again")

    def cloud_of_first(count: int) -> PlacedCloud:
        progress(f"{scene.name}, {recorded.label}, seed {recorded.seed}: cloud of {count} views")
        rows = np.array([scene.names.index(name) for name in views_of(recorded)[:count]], dtype=np.int64)
        return cloud_of(scene, rows, settings.sfm, episode, settings.device, reference.record.cameras)

    start = time.perf_counter()
    made = cloud_of_first(len(views_of(recorded)))
    seconds = time.perf_counter() - start
    sides = sides_of(reference, settings.voxel)
    counts = sorted(count for count in settings.views if count < len(views_of(recorded))) if sides else []
    threshold = settings.threshold * (reference.record.extent or 0.0)
    curve = []
    for count in counts:
        first = cloud_of_first(count)
        curve.append(_point(count, first, _shares(first, sides, threshold)))
    held = {name: held_against(side, made.reconstruction.cloud.positions) for name, side in sides.items()}
    record = _measured(recorded, reference, settings, made, sides, held, curve)
    _write_clouds(out, reference, made, sides, held)
    write_record(out / META, watch.facts(seconds))
    write_record(out / RECORD, record)


def views_of(episode: Episode) -> list[str]:
    """Return the names of an episode's views in the order of capture."""
    return [*episode.initial, *episode.selected]


def _check_episode(path: Path, episode: Episode, scene: Scene) -> None:
    if episode.scene_hash != scene.content_hash:
        raise UserError(path, "is of another version of the scene", "run the episode again")
    unknown = [name for name in views_of(episode) if name not in scene.names]
    if unknown:
        raise UserError(path, f"view {unknown[0]} is no image of the scene", "run the episode again")


def _shares(made: PlacedCloud, sides: Mapping[str, Side], threshold: float) -> dict[str, float]:
    """Return the SCR against each side."""
    positions = made.reconstruction.cloud.positions
    return {name: share_covered(side, positions, threshold) for name, side in sides.items()}


def _point(count: int, made: PlacedCloud, shares: Mapping[str, float]) -> CoveragePoint:
    found = made.reconstruction
    return CoveragePoint(
        views=count,
        registered=len(found.registered),
        points=len(found.cloud),
        scr=shares["against_reference"],
        true_scr=shares.get("against_surface"),
    )


def _measured(
    episode: Episode,
    reference: ReferenceFiles,
    settings: CoverageJob,
    made: PlacedCloud,
    sides: Mapping[str, Side],
    held: Mapping[str, Distances],
    curve: Sequence[CoveragePoint],
) -> Coverage:
    found, size = made.reconstruction, reference.record.extent
    measured = {
        name: numbers(side, found.cloud.positions, held[name], settings, size or 0.0) for name, side in sides.items()
    }
    shares = {name: each.scr for name, each in measured.items()}
    last = [_point(len(views_of(episode)), made, shares)] if sides else []
    return Coverage(
        scene=episode.scene,
        dataset=episode.dataset,
        scene_hash=episode.scene_hash,
        method=episode.method,
        seed=episode.seed,
        settings=settings.model_dump(mode="json"),
        reference=reference.record.settings,
        views=views_of(episode),
        registered=list(found.registered),
        left_out=dict(found.left_out),
        points=len(found.cloud),
        extent=size,
        placement=made.placement,
        against_reference=measured.get("against_reference"),
        against_surface=measured.get("against_surface"),
        curve=[*curve, *last],
        absent=_absent(reference, sides),
        notes=_notes(episode, reference, made),
    )


def _absent(reference: ReferenceFiles, sides: Mapping[str, Side]) -> dict[str, str]:
    """Return why a group of numbers is null."""
    if reference.record.extent is None:
        why = f"the reference has no extent: {reference.record.notes[-1]}"
        return dict.fromkeys(("against_reference", "against_surface"), why)
    if "against_surface" in sides:
        return {}
    known = reference.surface is not None
    why = "images are coarser than voxels everywhere" if known else "the true surface is not known"
    return {"against_surface": why}


def _notes(episode: Episode, reference: ReferenceFiles, made: PlacedCloud) -> list[str]:
    """Return what the back end tells, and that the views give no cloud where they do not."""
    found = made.reconstruction
    told = [f"{episode.scene}: {note}" for note in dict.fromkeys([*reference.record.notes, *found.notes])]
    if not len(found.cloud):
        told.append(f"{episode.label}, {episode.scene}, seed {episode.seed}: no cloud, SCR 0: {why_empty(found)}")
    return told


def _write_clouds(
    out: Path, reference: ReferenceFiles, made: PlacedCloud, sides: Mapping[str, Side], held: Mapping[str, Distances]
) -> None:
    cloud = made.reconstruction.cloud
    names = {"against_reference": DISTANCE, "against_surface": TRUE_DISTANCE}
    fields = {names[name]: each.of_cloud.astype(np.float32) for name, each in held.items()}
    write_cloud(out / CLOUD, cloud, fields)
    for name, file in (("against_reference", COVERED), ("against_surface", SURFACE)):
        points = reference.cloud if name == "against_reference" else reference.surface_cloud
        rows = sides[name].rows if name in sides else np.zeros(0, dtype=np.int64)
        distances = held[name].of_side if name in held else np.zeros(0)
        write_cloud(out / file, points[rows], {DISTANCE: distances.astype(np.float32)})
