"""The script of one exploration: every decision of the robot, its way, and the building from above."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from avs.report.collect_explorations import read_maps
from avs.report.page.page_pictures import picture
from avs.report.page.page_settings import PageSettings
from avs.report.page.script_files import plain_tree, rounded, told_apart, write_script
from avs.slam.evaluation.top_view import CELL
from avs.slam.loop.exploration_record import MAPS, Decision, ExplorationMeta, ExplorationRecord
from avs.system.files import file_hash
from avs.system.records import read_record

_MOST_PIXELS = 900  # a map needs more than a photograph


def write_exploration_script(record: Path, settings: PageSettings, page: Path) -> None:
    """Write ``<page>/slam/<building>/<method>-<seed>.js``; equal records give equal bytes.

    Args:
        record: ``exploration.json``; times and maps lie beside it.
        settings: of the page.
        page: the page's folder.

    Raises:
        UserError: a file is missing or damaged.
    """
    told = read_record(record, ExplorationRecord)
    meta = read_record(record.with_name("exploration.meta.json"), ExplorationMeta)
    arrays = read_maps(record.with_name(MAPS))
    facts = {
        "building": told.building,
        "method": told.method,
        "label": told.label,
        "seed": told.seed,
        "floor_area": told.floor_area,
        "surface_points": told.surface_points,
        "steps": told.steps,
        "ended": told.ended,
        "notes": told.notes,
        "decisions": [_decision(each) for each in told.decisions],
        "curve": [[point.step, point.scr_means, point.seen] for point in told.curve],
        "final": told.final.model_dump(mode="json"),
        "way": [rounded(place) for place in arrays["trajectory"][:, :2].tolist()],
        "above": _above(arrays, settings),
        "settings": plain_tree(told.settings),
        "provenance": _provenance(record, told, meta),
    }
    write_script(page, f"slam/{told.building}/{told.method}-{told.seed}", facts)


def _decision(told: Decision) -> dict[str, Any]:
    scores = told_apart([path.score for path in told.paths])
    return {
        "step": told.step,
        "gaussians": told.gaussians,
        "frontiers": [rounded([each.x, each.y]) for each in told.frontiers],
        "candidates": [rounded(pose[:2]) for pose in told.candidates],
        "paths": [
            {"candidate": path.candidate, "length": path.length, "score": score}
            for path, score in zip(told.paths, scores, strict=True)
        ],
        "chosen": told.chosen,
        "executed": told.executed,
    }


def _above(arrays: dict[str, npt.NDArray[Any]], settings: PageSettings) -> dict[str, Any]:
    """Return the building from above as a picture, x to the right and y upwards, with its corner and size in metres."""
    rgb = np.ascontiguousarray(arrays["above_rgb"].transpose(1, 0, 2)[::-1])
    larger = settings.model_copy(update={"long_side": _MOST_PIXELS})
    return {
        "picture": picture(rgb, larger),
        "origin": rounded(arrays["above_origin"].tolist()),
        "size": rounded([rgb.shape[1] * CELL, rgb.shape[0] * CELL]),
    }


def _provenance(record: Path, told: ExplorationRecord, meta: ExplorationMeta) -> dict[str, Any]:
    return {
        "git revision": meta.revision,
        "started": meta.started,
        "finished": meta.finished,
        "SHA-256 of exploration.json": file_hash(record),
        "SHA-256 of the building": told.building_hash,
        "machine": meta.machine,
        "packages": meta.packages,
    }
