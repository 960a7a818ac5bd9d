"""Where pictures of one view differ most: the squares that a figure magnifies, the same for all of its methods."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

_SHARE = 0.28  # edge of a square, in shares of the picture's short side

Window = tuple[int, int, int]
"""Left, top and edge of a square, in pixels."""


def differing_windows(
    pictures: Sequence[npt.NDArray[np.uint8]], truth: npt.NDArray[np.uint8], count: int
) -> list[Window]:
    """Return the squares in which pictures differ most, that of the largest difference first; none overlap.

    The difference at a pixel is the variance over the pictures, summed over the channels; of a single picture it is the
    squared difference to the truth. A square's difference is the sum over its pixels.

    Args:
        pictures: n images ``[height, width, 3]``.
        truth: the photograph, of the same shape.
        count: how many squares; fewer where the picture has no room for them.
    """
    values = np.stack([picture.astype(np.float64) for picture in pictures])
    spread = np.var(values, axis=0) if len(values) > 1 else np.square(values[0] - truth)
    edge = max(1, round(_SHARE * min(truth.shape[:2])))
    sums = _box_sums(spread.sum(axis=2), edge)
    found: list[Window] = []
    for _ in range(count):
        top, left = (int(place) for place in np.unravel_index(int(np.argmax(sums)), sums.shape))
        if sums[top, left] < 0:
            break
        found.append((left, top, edge))
        sums[max(0, top - edge + 1) : top + edge, max(0, left - edge + 1) : left + edge] = -1.0
    return found


def cut(picture: npt.NDArray[np.uint8], window: Window) -> npt.NDArray[np.uint8]:
    """Return the part of a picture that a window shows."""
    left, top, edge = window
    return picture[top : top + edge, left : left + edge]


def _box_sums(values: npt.NDArray[np.float64], edge: int) -> npt.NDArray[np.float64]:
    """Return the sum over each square that fits, at the place of its upper left corner; never less than 0."""
    sums = np.pad(values, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    boxes = sums[edge:, edge:] - sums[:-edge, edge:] - sums[edge:, :-edge] + sums[:-edge, :-edge]
    return np.asarray(np.maximum(boxes, 0.0))
