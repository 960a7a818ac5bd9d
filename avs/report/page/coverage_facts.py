"""What the page tells of coverage: the numbers of an episode, and the reference cloud with the distances to its own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from avs.coverage.coverage_record import Coverage
from avs.coverage.episode_coverage import COVERED, DISTANCE
from avs.report.page.script_files import encoded, rounded
from avs.scene.even_places import evenly_spread
from avs.sfm.cloud_file import read_cloud
from avs.system.errors import UserError
from avs.system.records import read_record

_DECADES = 1.0  # of the scale of colours, on each side of the threshold
_REMEDY = "run the job that makes it again"


@dataclass(frozen=True)
class CoveragePage:
    """What the page has of the coverage of one episode.

    Attributes:
        facts: numbers, and the distances of the cloud's points as one byte each.
        cloud: the points of the reference that are shown, which all episodes of a scene share; None without any.
    """

    facts: dict[str, Any]
    cloud: dict[str, Any] | None


def read_coverage_page(path: Path, scene_hash: str, most: int) -> CoveragePage:
    """Read the coverage of an episode.

    Args:
        path: ``coverage.json``; the cloud lies beside it.
        scene_hash: content hash of the scene.
        most: number of points that are shown.

    Raises:
        UserError: a file is missing, damaged, or of another version of the scene.
    """
    record = read_record(path, Coverage)
    if record.scene_hash != scene_hash:
        raise UserError(path, "is of another version of the scene", _REMEDY)
    facts: dict[str, Any] = {
        "threshold": record.settings["threshold"],
        "registered": len(record.registered),
        "left_out": record.left_out,
        "reference": None if record.against_reference is None else record.against_reference.model_dump(mode="json"),
        "surface": None if record.against_surface is None else record.against_surface.model_dump(mode="json"),
        "curve": [[point.views, point.scr, point.true_scr] for point in record.curve],
        "absent": record.absent,
        "notes": record.notes,
        "distances": None,
    }
    if record.extent is None:
        return CoveragePage(facts, None)
    cloud, fields = read_cloud(path.with_name(COVERED), _REMEDY)
    rows = evenly_spread(len(cloud), most)
    shares = fields[DISTANCE][rows].astype(np.float64) / record.extent
    facts["distances"] = encoded(_levels(shares, float(record.settings["threshold"])).tobytes())
    return CoveragePage(
        facts,
        {
            "points": len(cloud),
            "xyz": rounded(cloud.positions[rows].ravel().tolist()),
            "rgb": encoded(np.ascontiguousarray(cloud.colors[rows]).tobytes()),
        },
    )


def _levels(shares: npt.NDArray[np.float64], threshold: float) -> npt.NDArray[np.uint8]:
    """Return distances, in extents, as levels: 0 for a tenth of the threshold, 128 for it, 255 for ten times it."""
    decades = np.log10(np.maximum(shares, 1e-12) / threshold)
    return np.rint((np.clip(decades, -_DECADES, _DECADES) / _DECADES + 1) * 127.5).astype(np.uint8)
