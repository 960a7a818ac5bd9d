"""The encoding of brightness that pictures have: sRGB, IEC 61966-2-1."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float32]


def from_srgb(values: npt.NDArray[np.floating]) -> Array:
    """Undo the sRGB encoding of ``values`` in 0..1."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4).astype(np.float32)


def to_srgb(values: npt.NDArray[np.floating]) -> Array:
    """Encode linear ``values`` in 0..1 as sRGB."""
    return np.where(values <= 0.0031308, values * 12.92, 1.055 * np.maximum(values, 1e-9) ** (1 / 2.4) - 0.055).astype(
        np.float32
    )
