"""A view of all cameras of a scene from outside, without perspective: where it looks from, and outlines of cameras."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avs.scene.cameras import Cameras, FloatArray

_ELEVATION = np.radians(40.0)  # above the horizon, so that cameras at one height do not hide each other
_LEAST, _MOST = 0.035, 0.09  # depth of a camera's outline, in shares of the cameras' extent in the picture
_SPACED = 0.7  # and in distances between neighbouring cameras, where that lies between
_SMALL = 1e-9


@dataclass(frozen=True)
class Overview:
    """The axes of the picture in the scene's coordinates.

    Attributes:
        right: ``[3]`` unit vector.
        up: ``[3]`` unit vector.
        forward: ``[3]`` unit vector, away from the viewer.
    """

    right: FloatArray
    up: FloatArray
    forward: FloatArray

    def flattened(self, positions: FloatArray) -> FloatArray:
        """Return where positions ``[..., 3]`` lie in the picture, ``[..., 2]``, in units of the scene."""
        return np.stack([positions @ self.right, positions @ self.up], axis=-1)


def overview_of(cameras: Cameras) -> Overview:
    """Return a view from obliquely above that shows the cameras' horizontal spread from side to side.

    Up is the mean of what is up in their pictures. The viewer stands on the side that most of them look away from;
    where they look in all directions, on a side that the order of the axes decides.
    """
    rotations = cameras.world_to_camera[:, :3, :3]
    up = _unit(-rotations[:, 1].mean(axis=0), np.array([0.0, 0.0, 1.0]))
    centred = cameras.centers - cameras.centers.mean(axis=0)
    flat = centred - np.outer(centred @ up, up)
    right = _unit(np.linalg.svd(flat)[2][0], np.cross(up, [1.0, 0.3, 0.2]))
    right = _unit(right - (right @ up) * up, np.cross(up, [0.2, 1.0, 0.3]))
    level = np.cross(up, right)
    looked = float(rotations[:, 2].mean(axis=0) @ level)
    sign = np.sign(looked) if abs(looked) > 0.1 else np.sign(right[np.argmax(np.abs(right))])
    right, level = right * sign, level * sign
    forward = np.cos(_ELEVATION) * level - np.sin(_ELEVATION) * up
    return Overview(right, np.cross(right, forward), forward)


def outlines(cameras: Cameras, depth: float) -> FloatArray:
    """Return the outline of each camera: its centre and the corners of its picture at a depth.

    Args:
        cameras: n cameras.
        depth: how far before the centre the picture is drawn, in units of the scene.

    Returns:
        ``[n, 5, 3]`` positions: centre, upper left, upper right, lower right, lower left.
    """
    width, height = cameras.sizes[:, 0], cameras.sizes[:, 1]
    zero = np.zeros(len(cameras))
    columns = np.stack([zero, width, width, zero], axis=1)
    rows = np.stack([zero, zero, height, height], axis=1)
    focal = cameras.intrinsics[:, [0, 1], [0, 1]]
    middle = cameras.intrinsics[:, :2, 2]
    x = (columns - middle[:, :1]) / focal[:, :1]
    y = (rows - middle[:, 1:]) / focal[:, 1:]
    local = depth * np.stack([x, y, np.ones_like(x)], axis=2)
    corners = local @ cameras.world_to_camera[:, :3, :3] + cameras.centers[:, None]
    return np.concatenate([cameras.centers[:, None], corners], axis=1)


def outline_depth(cameras: Cameras, overview: Overview) -> float:
    """Return a depth at which outlines can be told apart and still be seen."""
    places = overview.flattened(cameras.centers)
    extent = float(np.linalg.norm(np.ptp(places, axis=0)))
    if extent < _SMALL or len(places) < 2:
        return max(extent, 1.0)
    distances = np.linalg.norm(places[:, None] - places[None], axis=2) + np.diag(np.full(len(places), np.inf))
    spaced = _SPACED * float(np.median(distances.min(axis=1)))
    return min(max(spaced, _LEAST * extent), _MOST * extent)


def _unit(vector: FloatArray, otherwise: FloatArray) -> FloatArray:
    """Return a vector of length 1 in the direction of ``vector``, or of another one where that has none."""
    length = float(np.linalg.norm(vector))
    chosen = vector if length > _SMALL else np.asarray(otherwise)
    return np.asarray(chosen / np.linalg.norm(chosen))
