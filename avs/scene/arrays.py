"""Checks of records of arrays that many hands fill."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np


def check_arrays(record: object, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Check the shapes of a record's arrays, by the names of its attributes, and that every number is finite.

    Raises:
        ValueError: a shape is another one, or an array holds NaN or an infinity.
    """
    for name, shape in shapes.items():
        array = getattr(record, name)
        if array.shape != shape:
            raise ValueError(f"{name} has shape {array.shape}, expected {shape}")
        if not np.isfinite(array).all():
            raise ValueError(f"{name} holds NaN or an infinity")
