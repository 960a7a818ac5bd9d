"""What the page tells of one episode: its selections, its test curve, and where its numbers come from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from avs.nvs.record import CurvePoint, Episode, EpisodeMeta, Step
from avs.report.page.scene_facts import CURVE
from avs.report.page.script_files import plain_tree, told_apart
from avs.selection import registry
from avs.system.files import file_hash
from avs.system.records import read_record


def episode_facts(path: Path, episode: Episode, names: Sequence[str]) -> dict[str, Any]:
    """Return what the record of an episode says, with images as places in ``names``.

    Args:
        path: ``episode.json``; the times of selections are read from ``episode.meta.json`` beside it.
        episode: what it holds.
        names: image names of the scene, ascending.

    Raises:
        UserError: the record of times is missing or damaged.
    """
    meta = read_record(path.with_name("episode.meta.json"), EpisodeMeta)
    places = {name: place for place, name in enumerate(names)}
    registered = registry.methods().get(episode.method)
    return {
        "method": episode.method,
        "label": episode.label,
        "seed": episode.seed,
        "chooses": episode.chooses,
        "measures": None if registered is None else registered.method.measures,
        "initial": [places[name] for name in episode.initial],
        "selected": [places[name] for name in episode.selected],
        "steps": [
            _step(step, before, places, times.total_seconds)
            for before, step, times in zip([None, *episode.steps[:-1]], episode.steps, meta.steps, strict=True)
        ],
        "curve": [_moment(point) for point in episode.curve],
        "test": [places[image.name] for image in episode.curve[-1].images],
        "kept": [places[name] for name in ([] if episode.pictures is None else episode.pictures.test)],
        "notes": episode.notes,
        "absent": episode.absent,
        "settings": plain_tree(
            {
                "protocol": episode.protocol,
                "representation": episode.representation,
                "selector": episode.selector,
            }
        ),
        "provenance": _provenance(path, episode, meta),
    }


def _step(step: Step, before: Step | None, places: dict[str, int], seconds: float) -> dict[str, Any]:
    """Return one selection; its candidates are None where they are those before without the views chosen then."""
    left = None if before is None else [name for name in before.candidates if name not in before.chosen]
    return {
        "iteration": step.iteration,
        "primitives": step.primitives,
        "candidates": None if step.candidates == left else [places[name] for name in step.candidates],
        "scores": None if step.scores is None else told_apart(step.scores),
        "chosen": [places[name] for name in step.chosen],
        "captured": step.captured,
        "seconds": float(f"{seconds:.4g}"),
    }


def _moment(point: CurvePoint) -> dict[str, Any]:
    """Return one moment of the test curve, with the values of each test image by metric."""
    values = {metric: [getattr(image, metric) for image in point.images] for metric in CURVE}
    return {"views": point.views, "iteration": point.iteration, "primitives": point.primitives} | values


def _provenance(path: Path, episode: Episode, meta: EpisodeMeta) -> dict[str, Any]:
    return {
        "record": f"{path.parent.name}/{path.name}",
        "record_sha256": file_hash(path),
        "scene_hash": episode.scene_hash,
        "weights": episode.weights_file,
        "weights_sha256": episode.weights_hash,
        "pictures_sha256": None if episode.pictures is None else episode.pictures.sha256,
        "revision": meta.revision,
        "started": meta.started,
        "finished": meta.finished,
        "device": meta.device,
        "total_seconds": float(f"{meta.total_seconds:.4g}"),
        "peak_memory_bytes": meta.peak_memory_bytes,
        "machine": meta.machine,
        "packages": meta.packages,
    }
