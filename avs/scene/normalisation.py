"""A scene's own unit and origin, so that neither those of the capture nor a stray camera has a say in any number.

Structure from motion leaves unit and origin free, and georeferenced captures have metres and millions of them. Every
scene is therefore moved and scaled when it is written: the mean of its pool's camera centres becomes the origin, and
its extent ``EXTENT``. What the suite knows in scene units, such as the near plane, is by this a share of the extent.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, FloatArray, IndexArray
from avs.scene.similarity import Similarity
from avs.system.errors import UserError
from avs.system.lists_of_names import some_of

EXTENT = 5.0
"""Extent of every scene in its own unit. COLMAP scales what it reconstructs so that the box around the middle 80
percent of the cameras has a diagonal of 10: in such units 3DGS, gsplat and FisherRF chose their constants."""

STRAY_SHARE, STRAY_FACTOR = 0.9, 10.0
"""A camera is stray if it is more than this factor farther from the median of all centres than this share of the
cameras. In ordinary captures, walks through rooms and flights over land among them, the farthest camera is at most 2.6
times as far."""

FARTHEST = 1e15
"""Scene units from the origin beyond which nothing may lie: float32 has to hold products of a few coordinates."""

_LEAST_EXTENT = 1e-10
"""Relative to the distance from the capture's origin: where cameras lie closer together, float64 cannot tell them apart
as well as float32 tells those of a scene."""


def camera_ball(centers: FloatArray) -> tuple[FloatArray, float]:
    """Return the mean ``[3]`` of camera centres ``[n, 3]`` and 1.1 times the greatest distance from it.

    These are the middle and the extent of 3DGS (``getNerfppNorm``).
    """
    middle: FloatArray = centers.mean(axis=0)
    return middle, float(1.1 * _lengths(centers - middle).max())


def stray_cameras(centers: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which of the camera centres ``[n, 3]`` are stray: see ``STRAY_FACTOR``. Fewer than a tenth are."""
    distances = _lengths(centers - np.median(centers, axis=0))
    ordinary = np.sort(distances)[int(STRAY_SHARE * (len(centers) - 1))]
    if _in_one_place(ordinary, centers):  # nothing to compare with
        return np.zeros(len(centers), dtype=bool)
    return np.asarray(distances > STRAY_FACTOR * ordinary)


def normalisation(
    cameras: Cameras, positions: FloatArray, pool: IndexArray, subject: str
) -> tuple[Similarity, IndexArray]:
    """Return the map from the scene's coordinates to those of the capture, and the indices of stray cameras.

    Test cameras have no part in it, as in 3DGS, unless the pool is a single camera.

    Args:
        cameras: of all images, in the capture's coordinates.
        positions: of all points, ``[p, 3]``, in the capture's coordinates; the map does not depend on them.
        pool: indices of the images that are no test images.
        subject: what errors name.

    Raises:
        UserError: the cameras stand in one place, or a camera or a point lies farther out than numbers reach.
    """
    centers = cameras.centers
    stray = stray_cameras(centers)
    rows = pool[~stray[pool]] if (~stray[pool]).sum() > 1 else np.flatnonzero(~stray)
    middle, extent = camera_ball(centers[rows])
    if _in_one_place(extent, centers):
        fault = f"its cameras ({len(rows)} of {len(centers)} that are no test images) stand in one place"
        raise UserError(
            subject, fault, "take photographs from different places, or run the structure from motion again"
        )
    for kind, places in (("camera", centers), ("point", positions)):
        if len(places) and not _lengths(places - middle).max() < FARTHEST * extent / EXTENT:
            fault = f"a {kind} lies more than {FARTHEST / EXTENT:.0e} times as far out as the cameras do"
            raise UserError(subject, fault, f"take that {kind} out of the model")
    to_capture = Similarity(scale=extent / EXTENT, translation=(float(middle[0]), float(middle[1]), float(middle[2])))
    return to_capture, np.flatnonzero(stray)


def _in_one_place(size: float, centers: FloatArray) -> bool:
    """Whether centres that lie within ``size`` of each other are one, for all that their coordinates tell."""
    return not size > _LEAST_EXTENT * float(np.median(_lengths(centers)))


def _lengths(vectors: FloatArray) -> FloatArray:
    """Return the lengths ``[n]`` of vectors ``[n, 3]``; infinite where they are too large for their squares."""
    with np.errstate(over="ignore"):
        lengths: FloatArray = np.linalg.norm(vectors, axis=1)
    return lengths


def stray_note(names: list[str]) -> str:
    """Return the line that tells of stray cameras; ``names`` are those of their images."""
    return (
        f"stray cameras, more than {STRAY_FACTOR:.0f} times as far out as {STRAY_SHARE:.0%} of all: "
        f"{some_of(names, 5)}; they are left out of the scene's extent, but remain views; "
        "take their images out of the model if the poses are wrong"
    )
