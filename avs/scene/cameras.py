"""Pinhole cameras in one convention.

Axes follow OpenCV (x right, y down, z forward). ``world_to_camera`` maps homogeneous world points to camera
coordinates. Pixel centres lie at half integers, as in COLMAP and gsplat: the centre of the upper left pixel is
(0.5, 0.5).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.scene.arrays import check_arrays

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Cameras:
    """A batch of n pinhole cameras; their image sizes may differ.

    Attributes:
        world_to_camera: ``[n, 4, 4]`` float64, rigid transforms, scene units.
        intrinsics: ``[n, 3, 3]`` float64, focal lengths and principal point in pixels, no skew.
        sizes: ``[n, 2]`` int64, image width and height in pixels.
    """

    world_to_camera: FloatArray
    intrinsics: FloatArray
    sizes: IndexArray

    def __post_init__(self) -> None:
        """Check shapes and that every number is finite.

        Raises:
            ValueError: a shape is wrong, or a matrix holds NaN or an infinity.
        """
        count = len(self.world_to_camera)
        check_arrays(self, {"world_to_camera": (count, 4, 4), "intrinsics": (count, 3, 3), "sizes": (count, 2)})

    def __len__(self) -> int:
        """Return the number of cameras."""
        return len(self.world_to_camera)

    def __getitem__(self, index: Sequence[int] | IndexArray | slice | int) -> Cameras:
        """Return the cameras at ``index``; a single integer gives a batch of one."""
        rows = [int(index)] if isinstance(index, (int, np.integer)) else index
        if not isinstance(rows, slice):
            rows = np.asarray(rows, dtype=np.int64)
        return Cameras(self.world_to_camera[rows], self.intrinsics[rows], self.sizes[rows])

    @property
    def centers(self) -> FloatArray:
        """Camera centres in world coordinates, ``[n, 3]``: minus the transposed rotation times the translation."""
        rotation, translation = self.world_to_camera[:, :3, :3], self.world_to_camera[:, :3, 3]
        centers: FloatArray = -np.einsum("nji,nj->ni", rotation, translation)
        return centers

    def by_size(self) -> Iterator[tuple[tuple[int, int], IndexArray]]:
        """Yield ``((width, height), indices)`` for each image size, indices ascending, sizes in order of appearance."""
        sizes = [(int(width), int(height)) for width, height in self.sizes]
        for size in dict.fromkeys(sizes):
            yield size, np.array([i for i, other in enumerate(sizes) if other == size], dtype=np.int64)

    def resized(self, sizes: IndexArray) -> Cameras:
        """Return the same cameras for images resized to ``sizes`` ``[n, 2]``; each axis scales by its own ratio."""
        ratio = np.asarray(sizes) / self.sizes
        intrinsics = self.intrinsics.copy()
        intrinsics[:, 0] *= ratio[:, :1]
        intrinsics[:, 1] *= ratio[:, 1:]
        return Cameras(self.world_to_camera, intrinsics, np.asarray(sizes, dtype=np.int64))


def concatenate(batches: Sequence[Cameras]) -> Cameras:
    """Join batches of cameras, in order."""
    return Cameras(
        np.concatenate([batch.world_to_camera for batch in batches]),
        np.concatenate([batch.intrinsics for batch in batches]),
        np.concatenate([batch.sizes for batch in batches]),
    )


def look_at(center: FloatArray, target: FloatArray, up: FloatArray) -> FloatArray:
    """Return the ``[4, 4]`` world-to-camera transform of a camera at ``center`` that looks at ``target``.

    Args:
        center: ``[3]`` world position of the camera.
        target: ``[3]`` world point in the middle of the image.
        up: ``[3]`` world direction that appears upwards in the image; need not be orthogonal or of unit length.

    Raises:
        ValueError: ``target`` equals ``center``, or ``up`` is parallel to the viewing direction.
    """
    forward = np.asarray(target, dtype=np.float64) - center
    right = np.cross(forward, up)
    if not np.linalg.norm(forward) > 0 or not np.linalg.norm(right) > 1e-9 * np.linalg.norm(forward):
        raise ValueError("the viewing direction is undefined: target equals center, or up is parallel to it")
    forward = forward / np.linalg.norm(forward)
    right = right / np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    transform = np.eye(4)
    transform[:3, :3] = rotation
    transform[:3, 3] = -rotation @ center
    return transform
