"""Sparse points of structure from motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import FloatArray, IndexArray


@dataclass(frozen=True)
class Points:
    """Sparse points of structure from motion.

    Attributes:
        positions: ``[p, 3]`` float64, world coordinates.
        colors: ``[p, 3]`` uint8, sRGB.
        observations: ``[o, 2]`` int64 rows of (point row, image index) in ascending order, without repetition: which
            image sees which point.
    """

    positions: FloatArray
    colors: npt.NDArray[np.uint8]
    observations: IndexArray

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.positions)
