"""The contract of what chooses a path."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from avs.scene.even_places import evenly_spread
from avs.slam.building.robot_camera import CameraSettings, Pose
from avs.slam.exploration.frontiers import Candidate
from avs.slam.exploration.planned_paths import PlannedPath
from avs.slam.mapping.gaussian_map import MapTensors
from avs.slam.mapping.keyframes import Keyframe

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Moment:
    """What is known when a path is to be chosen.

    Attributes:
        pose: of the robot.
        candidates: the poses that it could go to.
        tensors: the map.
        keyframes: the pictures that it was optimised on.
        camera: of the robot.
        rng: generator for random choices; its state depends on the building, the seed and the decision alone.
        decision: number of the decision, from 0.
        aside: stops the clock of the decision for a block that is a check and no part of it.
    """

    pose: Pose
    candidates: Sequence[Candidate]
    tensors: MapTensors
    keyframes: Sequence[Keyframe]
    camera: CameraSettings
    rng: np.random.Generator
    decision: int
    aside: Callable[[], AbstractContextManager[None]] = nullcontext


@dataclass(frozen=True)
class Shortlist:
    """The candidates to which paths are planned.

    Attributes:
        indices: of the candidates, ``[k]``.
        scores: one for each candidate that was scored by itself, higher is better, ``[candidates]``; or None.
    """

    indices: npt.NDArray[np.int64]
    scores: FloatArray | None = None


class PathScorer(Protocol):
    """Chooses among paths: the highest score is taken, ties go to the first.

    Attributes:
        label: the name printed in tables.
        notes: what a reader of results should know, without a full stop.
    """

    label: str
    notes: tuple[str, ...]

    def shortlist(self, moment: Moment, count: int) -> Shortlist:
        """Return at most ``count`` of the candidates, to which paths are planned."""
        ...

    def score(self, moment: Moment, listed: Shortlist, paths: Sequence[PlannedPath]) -> FloatArray:
        """Return one finite score for each of the n paths, ``[n]``; n is at least 1."""
        ...


def spread_keyframes(moment: Moment, limit: int | None) -> list[Keyframe]:
    """Return at most ``limit`` of the keyframes, evenly spread, the first among them; None: all."""
    count = len(moment.keyframes)
    return [moment.keyframes[place] for place in evenly_spread(count, count if limit is None else limit)]


def drawn(moment: Moment, count: int) -> Shortlist:
    """Return ``count`` candidates drawn by chance, ascending: the shortlist of what does not score endpoints."""
    chosen = moment.rng.permutation(len(moment.candidates))[:count]
    return Shortlist(np.sort(chosen).astype(np.int64))
