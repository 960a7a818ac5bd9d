"""A building from above, without what lies higher than a person: the background of maps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.slam.building.simulator import Simulator

CELL = 0.04
"""Edge of a pixel in metres."""

CEILING = 1.8
"""Metres above the floor: what lies higher would hide the rooms."""

_MARGIN = 0.2


@dataclass(frozen=True)
class TopView:
    """A picture from above.

    Attributes:
        rgb: ``[nx, ny, 3]`` uint8; white where there is nothing below.
        origin: ``[2]`` the corner of the first pixel, metres.
    """

    rgb: npt.NDArray[np.uint8]
    origin: npt.NDArray[np.float64]


def top_view(simulator: Simulator, points: npt.NDArray[np.float64], floor: float) -> TopView:
    """Return what lies under a plane ``CEILING`` above the ``floor``, around ``points`` ``[n, 3]``, at least one."""
    low, high = points[:, :2].min(axis=0) - _MARGIN, points[:, :2].max(axis=0) + _MARGIN
    counts = np.ceil((high - low) / CELL).astype(int)
    centres = (
        np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in counts), indexing="ij"), -1).reshape(-1, 2) * CELL + low
    )
    origins = np.concatenate([centres, np.full((len(centres), 1), floor + CEILING)], axis=1).astype(np.float32)
    hits = simulator.caster.nearest(origins, np.tile(np.array([0, 0, -1], np.float32), (len(origins), 1)))
    colors = np.where(hits.triangle[:, None] >= 0, simulator.colors.at(hits.triangle, hits.weights), 1)
    return TopView(np.rint(colors * 255).astype(np.uint8).reshape(*counts, 3), low)
