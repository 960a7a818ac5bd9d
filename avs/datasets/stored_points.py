"""Clouds in PLY files, without tracks, and whether cameras see them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, FloatArray
from avs.scene.points import Points
from avs.system.errors import UserError
from avs.system.regular_files import check_regular

_LOOKED_AT = 20_000
"""Points of a cloud that are looked for in the pictures, evenly spread over it."""


_ROUNDING = 0.01
"""By which a colour of 1 may come out greater."""


def read_ply(path: Path) -> Points:
    """Return the points of a PLY file; those without colours are black.

    Raises:
        UserError: the file is missing, damaged, or no cloud.
    """
    from plyfile import PlyData, PlyParseError

    if not path.exists():
        raise UserError(path, "the cloud is missing", "restore the file, or set points: triangulated")
    check_regular(path)
    try:
        vertices = PlyData.read(path)["vertex"]
        positions = np.stack([vertices[axis] for axis in "xyz"], axis=1).astype(np.float64)
        names = [name for name in ("red", "green", "blue") if name in vertices.data.dtype.names]
        colors = (
            np.stack([vertices[name] for name in names], axis=1) if len(names) == 3 else np.zeros((len(positions), 3))
        )
    except (PlyParseError, ValueError, KeyError, EOFError) as error:
        raise UserError(path, f"the cloud is damaged, or no cloud ({error})", "copy the file again") from error
    if not np.isfinite(positions).all() or not np.isfinite(colors).all():
        raise UserError(path, "a point of the cloud is not finite", "copy the file again, or take the point out")
    return Points(positions, _bytes_of(path, colors), np.zeros((0, 2), dtype=np.int64))


def _bytes_of(path: Path, colors: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """Return colours ``[n, 3]`` in 0..255, from bytes, 16 bits, or floats in 0..1."""
    if colors.dtype == np.uint16 and colors.max(initial=0) > 255:
        colors = np.rint(colors / 257)
    elif np.issubdtype(colors.dtype, np.floating) and colors.max(initial=0) <= 1 + _ROUNDING:
        colors = np.rint(np.clip(colors, 0, 1) * 255)
    if colors.min(initial=0) < 0 or colors.max(initial=0) > 255:
        fault = f"colours from {colors.min():g} to {colors.max():g}, neither in 0..1 nor in 0..255"
        raise UserError(path, fault, "save the cloud with colours of 8 bits")
    found: npt.NDArray[np.uint8] = np.rint(colors).astype(np.uint8)
    return found


def seen_shares(cameras: Cameras, positions: FloatArray) -> FloatArray:
    """Return which share of the points lies in front of each camera and in its picture, ``[n]``; nothing hides another.

    Args:
        cameras: n cameras.
        positions: ``[p, 3]`` world coordinates.
    """
    some = positions[:: max(1, len(positions) // _LOOKED_AT)]
    shares = np.zeros(len(cameras))
    for row, (transform, matrix, size) in enumerate(
        zip(cameras.world_to_camera, cameras.intrinsics, cameras.sizes, strict=True)
    ):
        local = some @ transform[:3, :3].T + transform[:3, 3]
        projected = local[local[:, 2] > 0] @ matrix.T
        pixels = projected[:, :2] / projected[:, 2:]
        shares[row] = ((pixels >= 0) & (pixels < size)).all(axis=1).sum() / max(1, len(some))
    return shares


def behind_all(cameras: Cameras, positions: FloatArray) -> np.ndarray:
    """Return which cameras have every point behind them, ``[n]`` bool."""
    forward, centers = cameras.world_to_camera[:, 2, :3], cameras.centers
    return np.array(
        [not ((positions - center) @ axis > 0).any() for axis, center in zip(forward, centers, strict=True)]
    )
