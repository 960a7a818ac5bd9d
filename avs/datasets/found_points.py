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
    """Return the points that the views see, each with the views that do, and notes for the scene.

    It takes minutes for some hundred views of 1600 pixels. Equal views give equal points.
    """
    from avs.sfm.sfm_settings import FeatureSettings
    from avs.sfm.sparse_models import triangulated

    found = triangulated(views, FeatureSettings(), seed=0)
    row = {name: index for index, name in enumerate(views.names)}
    rows = np.array([row[name] for name in found.reconstruction.registered], dtype=np.int64)
    points, images = found.points.observations.T
    observations = np.unique(np.stack([points, rows[images]], axis=1), axis=0)
    lost = [name for name in views.names if name not in set(found.reconstruction.registered)]
    notes = [f"{len(found.points)} points are triangulated from all pictures, with the given poses"]
    if lost:
        notes.append(f"{len(lost)} of {len(views)} images share no point with another ({some_of(lost)})")
    result = Points(found.points.positions, found.points.colors, observations)
    if are_doubtful(result, len(views)):
        told = f"three pictures agree on {sure_points(result)} points alone"
        notes.append(f"{told}: the poses may be wrong, or the pictures show little that can be told apart")
    return result, notes


def sure_points(points: Points) -> int:
    """Return how many points at least ``SURE`` views see."""
    return int((np.bincount(points.observations[:, 0], minlength=1) >= SURE).sum())


def are_doubtful(points: Points, views: int) -> bool:
    """Whether points triangulated from so many views speak against the poses, since so few are sure."""
    return sure_points(points) < max(views, _FEW * len(points))
