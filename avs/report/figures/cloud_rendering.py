"""Pictures of coloured clouds, as a pinhole camera sees them: each point a square, near ones before far ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, FloatArray

BACKGROUND = 245
"""Grey where there is no point."""

_SPREAD, _SMALLEST, _LARGEST = 1.3, 2.0, 0.022
"""A point's side in voxels: each lies anywhere in its voxel, and neighbours should leave no gap; then its least side in
pixels, and its greatest in shares of the picture's long side: one next to the camera would hide everything."""

_Window = tuple[float, float, float]


@dataclass(frozen=True)
class Projection:
    """Where points lie in a picture.

    Attributes:
        pixels: ``[n, 2]`` x and y.
        depth: ``[n]`` along the optical axis; 0 or less behind the camera.
        side: ``[n]`` pixels of the point's side.
        size: width and height of the picture.
    """

    pixels: FloatArray
    depth: FloatArray
    side: FloatArray
    size: tuple[int, int]

    def visible(self) -> npt.NDArray[np.bool_]:
        """Return which points lie in the picture, whether or not others hide them."""
        inside = ((self.pixels >= 0) & (self.pixels < np.array(self.size))).all(axis=1)
        seen: npt.NDArray[np.bool_] = inside & (self.depth > 0)
        return seen


def project(points: FloatArray, camera: Cameras, voxel: float, long_side: int) -> Projection:
    """Return where points ``[n, 3]`` lie in the picture of a batch of one camera, scaled to ``long_side`` pixels."""
    pose, matrix = camera.world_to_camera[0], camera.intrinsics[0]
    scale = long_side / camera.sizes[0].max()
    local = points @ pose[:3, :3].T + pose[:3, 3]
    depth = local[:, 2]
    ahead = np.where(depth > 0, depth, np.inf)
    pixels = scale * (local[:, :2] / ahead[:, None] * matrix[[0, 1], [0, 1]] + matrix[:2, 2])
    width, height = (round(float(scale * side)) for side in camera.sizes[0])
    side = np.minimum(_SPREAD * scale * voxel * matrix[0, 0] / ahead, _LARGEST * long_side)
    return Projection(pixels, depth, side, (width, height))


def magnified(projection: Projection, window: _Window, side: int) -> Projection:
    """Return the square ``window`` (left, top, edge in pixels) of a picture as a picture of ``side`` pixels."""
    left, top, edge = window
    factor = side / edge
    pixels = (projection.pixels - np.array([left, top])) * factor
    return Projection(pixels, projection.depth, projection.side * factor, (side, side))


def painted(projection: Projection) -> npt.NDArray[np.int64]:
    """Return the index ``[height, width]`` of the nearest point in each pixel, -1 where there is none."""
    width, height = projection.size
    picture = np.full((height, width), -1, dtype=np.int64)
    seen = np.flatnonzero(projection.visible())
    order = seen[np.argsort(-projection.depth[seen], kind="stable")]
    sides = np.maximum(projection.side[order], _SMALLEST)[:, None]
    first = np.rint(projection.pixels[order] - sides / 2).astype(np.int64)
    last = np.maximum(np.rint(projection.pixels[order] + sides / 2).astype(np.int64), first + 1)
    first = np.maximum(first, 0)
    # From the farthest to the nearest: the last one to paint a pixel stays.
    for row, (left, top), (right, bottom) in zip(order, first, last, strict=True):
        picture[top:bottom, left:right] = row
    return picture


def coloured(picture: npt.NDArray[np.int64], colors: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return the image ``[height, width, 3]`` of a painted picture with points of these colours ``[n, 3]``."""
    with_background = np.concatenate([colors, np.full((1, 3), BACKGROUND, dtype=np.uint8)])
    image: npt.NDArray[np.uint8] = with_background[picture]
    return image
