"""The greedy oracle: it knows the mesh, and goes where most of its surface that was never seen comes into view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avs.slam.building.robot_camera import camera_at
from avs.slam.evaluation.seen_surface import SeenSurface
from avs.slam.exploration.planned_paths import PlannedPath
from avs.slam.scoring.path_scorer import FloatArray, Moment, Shortlist, drawn

_LEAST_LENGTH = 0.25


class OracleScorer:
    """Most of the true surface seen for the first time at the end of the way, by metre of the way."""

    label = "Greedy oracle"
    notes: tuple[str, ...] = ()

    def __init__(self, surface: SeenSurface) -> None:
        """Look at ``surface``, which the exploration keeps up to date."""
        self._surface = surface

    def shortlist(self, moment: Moment, count: int) -> Shortlist:
        """Return ``count`` candidates by chance."""
        return drawn(moment, count)

    def score(self, moment: Moment, listed: Shortlist, paths: Sequence[PlannedPath]) -> FloatArray:
        """Return the number of new points of the surface per metre of each path, of which a quarter is the least."""
        ends = [moment.candidates[path.candidate].pose for path in paths]
        gains = [self._surface.new_from(camera_at(pose, moment.camera)) for pose in ends]
        return np.array([gain / max(path.length, _LEAST_LENGTH) for gain, path in zip(gains, paths, strict=True)])
