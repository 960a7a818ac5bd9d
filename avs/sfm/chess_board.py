"""Pixels of a picture sorted as the fields of a chess-board, for PatchMatch.

First those of one colour are visited, then the others, so that their order makes no difference and sixteen of one row
can be computed at once. They lie in ``[2, height, stride]`` arrays: colour, row, and half of the column. The colour of
column x in row y is ``(x + y) % 2``.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.rasterizer.simd_types import LANES

MARGIN = LANES
"""Places at either end of a row, so that neighbours need no cases."""

NOWHERE = -1.0
"""Inverse depth of places that are no pixels."""

FloatMap = npt.NDArray[np.float32]


def halves(values: FloatMap, outside: float) -> FloatMap:
    """Return the numbers ``[height, width]`` of pixels by colour, ``[2, height + 2, stride]``.

    Args:
        values: of the pixels.
        outside: of places that are no pixels: a row above and one below, and the ends of rows.
    """
    height, width = values.shape
    sorted_ = np.full((2, height + 2, _stride(width)), outside, dtype=np.float32)
    for color in range(2):
        for odd in range(2):  # rows of one parity
            own = values[odd::2, (odd + color) % 2 :: 2]
            sorted_[color, 1 + odd : 1 + height : 2, MARGIN : MARGIN + own.shape[1]] = own
    return sorted_


def whole(sorted_: FloatMap, width: int) -> FloatMap:
    """Return the numbers of pixels by row and column from those by colour."""
    height = sorted_.shape[1] - 2
    values = np.empty((height, width), dtype=np.float32)
    for color in range(2):
        for odd in range(2):
            own = values[odd::2, (odd + color) % 2 :: 2]
            own[:] = sorted_[color, 1 + odd : 1 + height : 2, MARGIN : MARGIN + own.shape[1]]
    return values


def columns_apart(grey: npt.NDArray[np.uint8], reach: int) -> FloatMap:
    """Return a picture with its even and its odd columns apart, ``[2, height + 2 reach, stride]``, edges repeated."""
    height, width = grey.shape
    stride = _stride(width)
    columns = 2 * (np.arange(stride) - MARGIN)
    rows = np.clip(np.arange(-reach, height + reach), 0, height - 1)
    return np.stack([grey[rows][:, np.clip(columns + odd, 0, width - 1)] for odd in range(2)]).astype(np.float32)


def _stride(width: int) -> int:
    return -(-width // (2 * LANES)) * LANES + 2 * MARGIN
