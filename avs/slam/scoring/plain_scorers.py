"""Choices without a model: the nearest candidate, and one by chance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avs.slam.exploration.planned_paths import PlannedPath
from avs.slam.scoring.path_scorer import FloatArray, Moment, Shortlist, drawn


class NearestScorer:
    """The candidate at the end of the shortest path (Yamauchi 1997)."""

    label = "Nearest frontier"
    notes: tuple[str, ...] = ()

    def shortlist(self, moment: Moment, count: int) -> Shortlist:
        """Return the ``count`` candidates that are nearest as the crow flies."""
        places = np.array([(each.pose.x, each.pose.y) for each in moment.candidates]).reshape(-1, 2)
        distances = np.linalg.norm(places - (moment.pose.x, moment.pose.y), axis=1)
        return Shortlist(np.argsort(distances, kind="stable")[:count].astype(np.int64))

    def score(self, moment: Moment, listed: Shortlist, paths: Sequence[PlannedPath]) -> FloatArray:
        """Return minus the length of each path in metres."""
        return -np.array([path.length for path in paths])


class RandomPathScorer:
    """A path by chance."""

    label = "Random path"
    notes: tuple[str, ...] = ()

    def shortlist(self, moment: Moment, count: int) -> Shortlist:
        """Return ``count`` candidates by chance."""
        return drawn(moment, count)

    def score(self, moment: Moment, listed: Shortlist, paths: Sequence[PlannedPath]) -> FloatArray:
        """Return a random number in 0..1 for each path."""
        return moment.rng.random(len(paths))
