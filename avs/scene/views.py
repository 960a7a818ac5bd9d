"""Photographs with their cameras and names."""

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
        names: n image names. Within a scene a name stands for one photograph: what is computed of a photograph can be
            kept under its name.
    """

    cameras: Cameras
    images: tuple[npt.NDArray[np.uint8], ...]
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        """Refuse parts of different lengths.

        Raises:
            ValueError: there are not as many images and names as cameras.
        """
        if not len(self.cameras) == len(self.images) == len(self.names):
            counts = f"{len(self.cameras)} cameras, {len(self.images)} images and {len(self.names)} names"
            raise ValueError(f"views need as many of each: {counts}")

    def __len__(self) -> int:
        """Return the number of views."""
        return len(self.images)

    def __getitem__(self, rows: Sequence[int] | IndexArray) -> Views:
        """Return the views at ``rows``, in that order."""
        return Views(
            self.cameras[rows], tuple(self.images[row] for row in rows), tuple(self.names[row] for row in rows)
        )

    def extended(self, other: Views) -> Views:
        """Return these views followed by ``other``."""
        return Views(concatenate([self.cameras, other.cameras]), self.images + other.images, self.names + other.names)
