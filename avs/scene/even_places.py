"""A few of many, evenly spread: views, test images, moments."""

from __future__ import annotations

import numpy as np


def evenly_spread(count: int, wanted: int) -> list[int]:
    """Return at most ``wanted`` of the places 0 to ``count - 1``, ascending, the first and the last among them.

    With ``wanted`` 1 it is the first; with 0 there is none.
    """
    chosen = min(wanted, count)
    places: list[int] = np.unique(np.linspace(0, count - 1, chosen).round().astype(int)).tolist()
    return places
