"""Scene: cameras, images, split and points, in the COLMAP layout on disk.

A scene folder holds ``images/``, ``sparse/0/*.bin`` (PINHOLE cameras) and ``scene.json``; any COLMAP viewer opens it. Scenes with
known geometry add ``depth/<image stem>.npy`` (float32 metres along the optical axis) and ``mesh.ply``.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from avs.cameras import Cameras, IndexArray
from avs.representations.base import Views


@dataclass(frozen=True)
class Points:
    """Sparse points of structure from motion.

    Attributes:
        positions: ``[p, 3]`` float64, world coordinates.
        colors: ``[p, 3]`` uint8, sRGB.
        observations: ``[o, 2]`` int64 rows of (point row, image index) in ascending order: which image sees which point.
    """

    positions: npt.NDArray[np.float64]
    colors: npt.NDArray[np.uint8]
    observations: IndexArray

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.positions)


@dataclass(frozen=True)
class Scene:
    """One capture. Images are in ascending order of name; ``cameras`` and ``names`` share that order.

    Attributes:
        name: identifier, ``[a-z0-9_]+``.
        dataset: name of the data set it belongs to, such as ``orbit`` or ``captures``.
        folder: where it lies on disk; images are read from ``folder / "images"`` on demand.
        names: image file names, ascending.
        cameras: one per image, of the images' pixel sizes.
        test: indices of the test images, ascending. All others are the pool of candidates.
        points: sparse points; may be empty.
        extent: 1.1 times the greatest distance of a camera centre from the mean of all centres (3DGS, ``getNerfppNorm``).
        source: where the pictures come from, one line.
        licence: their terms, one line.
        content_hash: SHA-256 over the images, the cameras, the split and the points.
    """

    name: str
    dataset: str
    folder: Path
    names: tuple[str, ...]
    cameras: Cameras
    test: IndexArray
    points: Points
    extent: float
    source: str
    licence: str
    content_hash: str

    @property
    def pool(self) -> IndexArray:
        """Indices of the candidate images, ascending: every image that is not a test image."""
        return np.setdiff1d(np.arange(len(self.names)), self.test)

    def views(self, indices: IndexArray) -> Views:
        """Read the images at ``indices`` and return them with their cameras, in the order given.

        Raises:
            UserError: an image is missing, truncated, or not of its camera's size.
        """
        raise NotImplementedError


def write_scene(scene: Scene, images: tuple[npt.NDArray[np.uint8], ...]) -> None:
    """Placeholder of the contract: see ``read_scene``."""
    raise NotImplementedError


def read_scene(folder: Path) -> Scene:
    """Read the scene in ``folder``.

    Raises:
        UserError: a file is missing, damaged or contradicts another.
    """
    raise NotImplementedError
