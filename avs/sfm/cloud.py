"""Clouds of coloured points."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from avs.scene.arrays import check_arrays
from avs.scene.cameras import FloatArray, IndexArray


@dataclass(frozen=True)
class Cloud:
    """A cloud of n points; n may be 0.

    Attributes:
        positions: ``[n, 3]`` float64, finite, world coordinates.
        colors: ``[n, 3]`` uint8, sRGB.
        confidence: ``[n]`` float32, finite, at least 0: the greater, the surer. Its unit is the back end's own, such as
            the number of views that see the point.
    """

    positions: FloatArray
    colors: npt.NDArray[np.uint8]
    confidence: npt.NDArray[np.float32]

    def __post_init__(self) -> None:
        """Check shapes, and that every number is finite.

        Raises:
            ValueError: a shape is wrong, or a number is NaN or infinite.
        """
        count = len(self.positions)
        check_arrays(self, {"positions": (count, 3), "colors": (count, 3), "confidence": (count,)})

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.positions)

    def __getitem__(self, rows: IndexArray | npt.NDArray[np.bool_] | slice) -> Cloud:
        """Return the points of ``rows``."""
        return Cloud(self.positions[rows], self.colors[rows], self.confidence[rows])

    def moved_to(self, positions: FloatArray) -> Cloud:
        """Return the same points at other positions ``[n, 3]``."""
        return replace(self, positions=positions)


def empty_cloud() -> Cloud:
    """Return a cloud without points."""
    return Cloud(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.uint8), np.zeros(0, dtype=np.float32))
