"""Any method of Task A as what chooses a path: it scores the views at the end of each path, or along it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avs.scene.cameras import concatenate
from avs.scene.views import Views
from avs.selection.choice import notes_of, select_views
from avs.selection.contract import Method, Selector, State
from avs.selection.untouched import untouched
from avs.slam.building.robot_camera import Pose, cameras_at
from avs.slam.exploration.planned_paths import PlannedPath
from avs.slam.mapping.map_view import MapView
from avs.slam.scoring.path_scorer import FloatArray, Moment, Shortlist, drawn, spread_keyframes
from avs.slam.scoring.path_settings import SelectorPathSettings
from avs.system.errors import UserError


class SelectorScorer:
    """A method that was written for views scores paths, without a line of its own."""

    def __init__(self, method: Method, selector: Selector, settings: SelectorPathSettings) -> None:
        """Score by ``selector``, which ``method`` built."""
        self.label = method.label
        self.notes = tuple(notes_of(method, selector))
        self._method, self._selector, self._settings = method, selector, settings

    def shortlist(self, moment: Moment, count: int) -> Shortlist:
        """Return ``count`` candidates by chance."""
        return drawn(moment, count)

    def score(self, moment: Moment, listed: Shortlist, paths: Sequence[PlannedPath]) -> FloatArray:
        """Return the aggregated scores of the views of each path; minus those where the method takes the lowest."""
        groups = [self._poses(moment, path) for path in paths]
        poses = [pose for group in groups for pose in group]
        state = State(
            representation=MapView(moment.tensors),
            captured=self._captured(moment),
            candidates=cameras_at(poses, moment.camera),
            names=tuple(f"decision-{moment.decision:04d}-view-{index:04d}" for index in range(len(poses))),
            rng=moment.rng,
            step=moment.decision,
        )
        with untouched(self._method.label, state, aside=moment.aside):
            selection = select_views(self._method, self._selector, state, 1)
        scores = selection.scores
        if scores is None or (selection.scored is not None and not selection.scored.all()):
            fault = "does not score every view, so that paths cannot be compared"
            raise UserError(f"method {self._method.label}", fault, "choose another for the exploration")
        signed = -scores if self._method.chooses == "lowest" else scores
        ends = np.cumsum([len(group) for group in groups])[:-1]
        return np.array([_AGGREGATES[self._settings.aggregate](part) for part in np.split(signed, ends)])

    def _poses(self, moment: Moment, path: PlannedPath) -> list[Pose]:
        end = moment.candidates[path.candidate].pose
        if self._settings.views == "endpoint":
            return [end]
        return [*path.poses[self._settings.every - 1 :: self._settings.every], end]

    def _captured(self, moment: Moment) -> Views:
        """Return keyframes as captured views; the first is always among them."""
        keyframes = spread_keyframes(moment, self._settings.keyframes)
        return Views(
            concatenate([keyframe.camera for keyframe in keyframes]),
            tuple(keyframe.rgb for keyframe in keyframes),
            tuple(f"frame-{keyframe.number:06d}" for keyframe in keyframes),
        )


_AGGREGATES = {
    "mean": lambda scores: float(np.mean(scores)),
    "best": lambda scores: float(np.max(scores)),
    "worst": lambda scores: float(np.min(scores)),
    "sum": lambda scores: float(np.sum(scores)),
}
