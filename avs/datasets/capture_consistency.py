"""Whether the parts of a model belong together: each image sees its points where the model says that it does."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avs.datasets.undistortion import projected
from avs.scene.colmap import NO_POINT, Model, ModelImage
from avs.scene.colmap.conversion import rotation_matrix, sorted_images
from avs.scene.points import Points
from avs.system.lists_of_names import some_of

_FEWEST = 3
"""Observations from which an image can be judged."""

_SHARE, _PIXELS = 0.01, 4.0
"""A median distance beyond this share of the longer side, and this many pixels, is no measurement: of single points
COLMAP keeps those within 4 pixels."""


def consistency_notes(model: Model) -> list[str]:
    """Return a note of the images whose points lie elsewhere than where the model says they are seen, if there are any.

    A pose, camera or cloud that was damaged, edited, or taken from another reconstruction is whole by itself, and gives
    wrong numbers without a word; only the parts together tell.
    """
    judged = {image.name: _is_displaced(model, image) for image in sorted_images(model)}
    displaced = [name for name, is_displaced in judged.items() if is_displaced]
    if not displaced:
        return []
    which = f"{len(displaced)} of {len(model.images)} images ({some_of(displaced)})"
    return [
        f"{which} see their points more than {_SHARE:.0%} of their side from where the model says: "
        "its cameras, poses and points may not belong together"
    ]


def unseen_notes(names: Sequence[str], listed: Points, seen: Points) -> list[str]:
    """Return a note of the images that see less than half of what they observe by the model, if there are any.

    A pose that is inverted, or far away, has its points behind the camera or beside the picture. Without keypoints, as
    many programs write models, nothing else tells.

    Args:
        names: of the images, by their index in both.
        listed: the points with all observations of the model.
        seen: the points with the observations that lie in the pictures.
    """
    counts = [np.bincount(points.observations[:, 1], minlength=len(names)) for points in (listed, seen)]
    blind = [name for name, told, left in zip(names, *counts, strict=True) if told >= _FEWEST and left < told / 2]
    if not blind:
        return []
    return [
        f"{len(blind)} of {len(names)} images ({some_of(blind)}) have most of the points that they "
        "observe behind them or outside the picture: their poses may be wrong or inverted"
    ]


def _is_displaced(model: Model, image: ModelImage) -> bool:
    """Whether the median distance between an image's points and its keypoints is no measurement; False if unknown."""
    seen = np.flatnonzero(image.points != NO_POINT)
    keypoints = image.keypoints[seen]
    if len(seen) < _FEWEST or not np.isfinite(keypoints).all() or (keypoints == keypoints[0]).all():
        return False  # programs that have no keypoints write zeros
    camera = model.cameras[image.camera_id]
    points = model.positions[np.searchsorted(model.point_ids, image.points[seen])]
    local = points @ rotation_matrix(image.quaternion).T + image.translation
    distances = np.hypot(*(projected(local, camera) - keypoints).T)  # no square, which would overflow
    return bool(np.median(distances) > max(_PIXELS, _SHARE * max(camera.width, camera.height)))
