"""Points for pictures with poses that came without tracks: triangulated from the pictures themselves.

Features are matched between views near each other, and a match counts where it agrees with the poses
(``avs.sfm.sparse``). So what is found also tells whether the poses mean what the user says: points that three views see
at places that agree are hardly ever found by chance.
"""

from __future__ import annotations

import numpy as np

from avs.scene.points import Points
from avs.scene.views import Views
from avs.system.lists_of_names import some_of

SURE = 3
"""Views from which a point is sure: two views agree on many a wrong match, since it only has to lie on a line."""

_FEW = 0.1
"""Below this share of sure points something is wrong: with right poses it is mostly a half."""


def triangulated_points(views: Views) -> tuple[Points, list[str]]:
    """Return the points that three views or more see, each with the views that do, and notes for the scene.

    Where those are so few that something is wrong, points that two views see are among them. It takes minutes for some
    hundred views of 1600 pixels. Equal views give equal points.
    """
    from avs.sfm.sfm_settings import FeatureSettings
    from avs.sfm.sparse_models import triangulated

    found = triangulated(views, FeatureSettings(), seed=0)
    row = {name: index for index, name in enumerate(views.names)}
    rows = np.array([row[name] for name in found.reconstruction.registered], dtype=np.int64)
    points, images = found.points.observations.T
    observations = np.unique(np.stack([points, rows[images]], axis=1), axis=0)
    result = Points(found.points.positions, found.points.colors, observations)
    doubtful = are_doubtful(result, len(views))
    if not doubtful:
        result = _sure(result)
    notes = [f"{len(result)} points are triangulated from all pictures, with the given poses"]
    seeing = set(result.observations[:, 1].tolist())
    lost = [name for index, name in enumerate(views.names) if index not in seeing]
    if lost:
        notes.append(f"{len(lost)} of {len(views)} images share no point with others ({some_of(lost)})")
    if doubtful:
        told = f"three pictures agree on {sure_points(result)} points alone"
        notes.append(f"{told}: the poses may be wrong, or the pictures show little that can be told apart")
    return result, notes


def _sure(points: Points) -> Points:
    """Return the points that at least ``SURE`` views see, as COLMAP's own mapping keeps them alone."""
    kept = np.bincount(points.observations[:, 0], minlength=len(points)) >= SURE
    observations = points.observations[kept[points.observations[:, 0]]]
    observations[:, 0] = (np.cumsum(kept) - 1)[observations[:, 0]]
    return Points(points.positions[kept], points.colors[kept], observations)


def sure_points(points: Points) -> int:
    """Return how many points at least ``SURE`` views see."""
    return int((np.bincount(points.observations[:, 0], minlength=1) >= SURE).sum())


def are_doubtful(points: Points, views: int) -> bool:
    """Whether points triangulated from so many views speak against the poses, since so few are sure."""
    return sure_points(points) < max(views, _FEW * len(points))
