"""Runs an exploration and writes its record, its times, and what its figures are drawn from."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import astuple
from pathlib import Path

import numpy as np

from avs.selection.contract import Resources
from avs.slam.building.robot_camera import Pose, camera_at, cameras_at
from avs.slam.evaluation.map_quality import coverage_of, fused_cloud, map_quality
from avs.slam.evaluation.seen_surface import SeenSurface
from avs.slam.evaluation.top_view import CELL, top_view
from avs.slam.evaluation.trajectory_error import absolute_trajectory_error
from avs.slam.exploration.frontiers import frontiers
from avs.slam.exploration.occupancy import free_space
from avs.slam.loop.exploration_checkpoint import load_exploration, save_exploration
from avs.slam.loop.exploration_loop import BUDGET_SPENT, Exploration, pose_numbers
from avs.slam.loop.exploration_record import (
    MAPS,
    MAPS_HEADER,
    CoveragePoint,
    ExplorationMeta,
    ExplorationRecord,
    FinalMeasures,
)
from avs.slam.loop.robot_world import World, open_world
from avs.slam.loop.slam_settings import SlamSettings
from avs.slam.scoring.path_choice import build_scorer
from avs.slam.scoring.path_scorer import PathScorer
from avs.system import provenance
from avs.system.records import write_record
from avs.system.seeds import seed_global_generators
from avs.system.tensor_files import write_tensors
from metrics.coverage import nearest_distances

Progress = Callable[[str], None]

CHECKPOINT = "checkpoint.safetensors"

_DECISIONS_BETWEEN = 10


def run_exploration(
    mesh: Path,
    name: str,
    method: str,
    settings: SlamSettings,
    seed: int,
    weights: Path | None,
    out: Path,
    progress: Progress,
    code: str = "",
) -> None:
    """Explore a building and write to the folder ``out``; one that was killed goes on from its last checkpoint.

    Written are ``maps.safetensors``, ``exploration.meta.json`` and, at the end, ``exploration.json``.

    Args:
        mesh: the building's file.
        name: of the building, for records.
        method: identifier of what chooses, for records.
        settings: of everything.
        seed: of the start, the mapper and what chooses.
        weights: of the scorer that a method of Task A names, or None.
        out: folder of the results.
        progress: receives one line about each point of the curve.
        code: names the version of the program and of the weights; a checkpoint of another one is not gone on from.

    Raises:
        UserError: the building, the start, the method or its weights are not as they need to be.
    """
    started, start = provenance.now(), provenance.clock("cpu")
    world = open_world(mesh, name, settings, seed)
    surface = SeenSurface(world.surface, world.simulator, settings.evaluation.threshold)
    exploration = Exploration(world, settings, seed, surface)
    seed_global_generators("method", name, method, seed)
    scorer = build_scorer(settings.scorer, surface, Resources(weights))
    _explore(exploration, scorer, out / CHECKPOINT, progress, code)
    with exploration.clocks.of("measure"):
        exploration.measure()
        record = _record(exploration, method, scorer, seed)
    _write_maps(out / MAPS, exploration)
    write_record(out / "exploration.meta.json", _meta(exploration, started, provenance.clock("cpu") - start))
    write_record(out / "exploration.json", record)
    (out / CHECKPOINT).unlink(missing_ok=True)


def _explore(exploration: Exploration, scorer: PathScorer, checkpoint: Path, progress: Progress, code: str) -> None:
    """Go on from a checkpoint, or begin, and explore to the end."""
    if load_exploration(checkpoint, exploration, code):
        progress(_line(exploration, scorer))
    else:
        exploration.begin()
    told = len(exploration.curve)
    while not exploration.ended:
        exploration.decide_and_go(scorer)
        if len(exploration.curve) > told:
            told = len(exploration.curve)
            progress(_line(exploration, scorer))
        if exploration.decisions and len(exploration.decisions) % _DECISIONS_BETWEEN == 0 and not exploration.ended:
            save_exploration(checkpoint, exploration, code)


def _meta(exploration: Exploration, started: str, total: float) -> ExplorationMeta:
    return ExplorationMeta(
        seconds={**exploration.clocks.seconds, **exploration.mapper.seconds},
        decision_seconds=exploration.clocks.decisions,
        score_seconds=exploration.clocks.scores,
        memory_bytes=exploration.clocks.memory,
        total_seconds=total,
        machine=provenance.machine("cpu"),
        packages=provenance.packages(),
        revision=provenance.revision(),
        started=started,
        finished=provenance.now(),
    )


def _line(exploration: Exploration, scorer: PathScorer) -> str:
    point, steps = exploration.curve[-1], exploration.plan.steps
    place = f"{exploration.world.name}, {scorer.label}, seed {exploration.seed}"
    return f"{place}: action {point.step} of {steps}, coverage {100 * point.scr_means:.1f} %"


def _record(exploration: Exploration, method: str, scorer: PathScorer, seed: int) -> ExplorationRecord:
    world, settings = exploration.world, exploration.settings
    notes = [f"{world.name}: {note}" for note in world.notes] + list(scorer.notes)
    farthest = farthest_kept(exploration.mapper.radius, settings)
    if farthest < settings.exploration.occupancy.reach:
        notes.append(
            f"{world.name}, seed {seed}: Gaussians that begin more than {farthest:.1f} m from the camera are pruned as "
            f"too large, by mapper.pruning.scale and the {3 * exploration.mapper.radius:.1f} m that the first "
            "picture reaches"
        )
    if exploration.ended != BUDGET_SPENT:
        steps = f"after {exploration.step} of {settings.exploration.steps} actions"
        notes.append(f"{world.name}, {scorer.label}, seed {seed}: ended {steps}, because {exploration.ended}")
    return ExplorationRecord(
        building=world.name,
        building_hash=world.digest,
        method=method,
        label=scorer.label,
        seed=seed,
        settings=settings.model_dump(mode="json"),
        start=pose_numbers(world.start),
        floor_area=world.floor_area,
        surface_points=len(world.surface),
        steps=exploration.step,
        ended=exploration.ended,
        notes=notes,
        decisions=exploration.decisions,
        curve=exploration.curve,
        final=_final(exploration, world, settings),
    )


def farthest_kept(radius: float, settings: SlamSettings) -> float:
    """Return the depth in metres beyond which a new Gaussian is larger than the pruning allows.

    SplaTAM prunes by the ``radius`` that the first picture gives the scene. A start close to a wall makes it small, and
    a camera of few pixels, or ``growth.stride``, makes new Gaussians large.
    """
    if not any(iteration < settings.mapper.iterations for iteration in settings.mapper.pruning.iterations):
        return math.inf
    focal = float(camera_at(Pose(0, 0, 0, 0), settings.camera).intrinsics[0, 0, 0])
    return settings.mapper.pruning.scale * radius * focal / settings.mapper.growth.stride


def _final(exploration: Exploration, world: World, settings: SlamSettings) -> FinalMeasures:
    tensors, evaluation = exploration.mapper.tensors, settings.evaluation
    cameras = cameras_at(exploration.trajectory, settings.camera)
    places = range(0, len(cameras), evaluation.fused_every)
    fused = fused_cloud(tensors, [cameras[place] for place in places], evaluation)
    poses = list(world.poses)
    quality = map_quality(tensors, world.simulator, poses, settings.camera, evaluation) if poses else None
    error = None
    if settings.mapper.tracking is not None:
        found = np.array([-pose[:3, :3].T @ pose[:3, 3] for pose in exploration.mapper.poses])
        error = absolute_trajectory_error(found, cameras.centers)
    last = exploration.curve[-1]
    return FinalMeasures(
        scr_means=last.scr_means,
        scr_fused=coverage_of(world.surface, fused, evaluation.threshold),
        seen=last.seen,
        scr_area=curve_area(exploration.curve, settings.exploration.steps),
        depth_mae=None if quality is None else quality.depth_mae,
        psnr=None if quality is None else quality.psnr,
        ssim=None if quality is None else quality.ssim,
        empty=None if quality is None else quality.empty,
        poses=len(poses),
        trajectory_error=error,
        path_length=exploration.length,
        collisions=exploration.collisions,
    )


def curve_area(curve: list[CoveragePoint], steps: int) -> float:
    """Return the mean of the coverage over ``steps`` actions, by trapezoids; after an early end it stays as it was."""
    x = [point.step for point in curve] + [max(steps, curve[-1].step)]
    y = [point.scr_means for point in curve] + [curve[-1].scr_means]
    return float(np.trapezoid(y, x) / x[-1]) if x[-1] else y[0]


def _write_maps(path: Path, exploration: Exploration) -> None:
    """Write what figures are drawn from; arrays are in metres in the building's upright axes."""
    world, grid, tensors = exploration.world, exploration.grid, exploration.mapper.tensors
    means = np.asarray(tensors["means"].detach().numpy())
    free = free_space(grid, means, exploration.believed)
    left = frontiers(grid, free, exploration.believed, exploration.plan.frontiers)
    cells = [grid.centres(one.cells) for one in left]
    above = top_view(world.simulator, world.surface, world.start.floor)
    arrays = {
        "trajectory": np.array([astuple(pose) for pose in exploration.trajectory]),
        "surface": world.surface.astype(np.float32),
        "above_rgb": above.rgb,
        "above_origin": above.origin,
        "distance": nearest_distances(world.surface, means).astype(np.float32),
        "seen": exploration.surface.seen,
        "frontiers": np.concatenate([np.zeros((0, 2)), *cells]),
        "occupied": (grid.occupied >= np.maximum(grid.free, 1)).astype(np.uint8),
        "free": (grid.free > grid.occupied).astype(np.uint8),
        "grid_origin": grid.origin,
        "means": means,
        "rgb": np.asarray(tensors["rgb"].detach().numpy()),
        "opacities": np.asarray(tensors["opacities"].detach().numpy()),
        "scales": np.asarray(tensors["scales"].detach().numpy()),
    }
    write_tensors(
        path, arrays, MAPS_HEADER, {"building": world.name, "grid_cell": grid.settings.cell, "above_cell": CELL}
    )
