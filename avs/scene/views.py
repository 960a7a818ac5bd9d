"""Photographs with their cameras."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, IndexArray, concatenate


@dataclass(frozen=True)
class Views:
    """Captured photographs with their cameras.

    Attributes:
        cameras: n cameras.
        images: n arrays ``[height, width, 3]`` uint8, sRGB, of the cameras' sizes.
    """

    cameras: Cameras
    images: tuple[npt.NDArray[np.uint8], ...]

    def __len__(self) -> int:
        """Return the number of views."""
        return len(self.images)

    def __getitem__(self, rows: Sequence[int] | IndexArray) -> Views:
        """Return the views at ``rows``, in that order."""
        return Views(self.cameras[rows], tuple(self.images[row] for row in rows))

    def extended(self, other: Views) -> Views:
        """Return these views followed by ``other``."""
        return Views(concatenate([self.cameras, other.cameras]), self.images + other.images)
