"""Which way is up in a mesh, and how long its unit is: told by the format, and found by the height of a building."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
from pydantic import Field, PositiveFloat

from avs.slam.building.building_mesh import Building, FloatArray
from avs.system.errors import UserError
from avs.system.models import StrictModel

Axis = Literal["auto", "y", "z"]

HEIGHTS = (1.8, 30.0)
"""Heights in metres that a building, of one storey or of several, may have."""

_UNITS = {"centimetres": 0.01, "millimetres": 0.001, "inches": 0.0254, "feet": 0.3048}
_IN_METRES = (".glb", ".gltf")
"""Formats that say what their unit is; one of feet can be as high as a building in metres."""
_TAKEN = "its unit is taken for {name}, in which it is {height:.1f} m high"
_CLEARLY = 1.1
_USUAL_HEIGHT = 3.5


class FrameSettings(StrictModel):
    """Axes and unit of a mesh."""

    up: Axis = Field(
        default="auto",
        description="axis that points upwards; auto: of y and z the one along which the mesh is clearly shorter, and "
        "where neither is, y for glTF and OBJ and z for PLY",
    )
    metres: PositiveFloat | None = Field(
        default=None,
        description="length of the mesh's unit in metres; null: a metre where that makes its height that of a "
        "building, 1.8 to 30 m, else the one of centimetre, millimetre, inch and foot that makes it nearest to 3.5 m",
    )


def upright(building: Building, settings: FrameSettings, suffix: str, subject: object) -> Building:
    """Return the building in metres, z upwards, with notes where that was not plain from the format.

    A mesh with y upwards is turned about x, so that its y becomes z and its z becomes -y.

    Args:
        building: in the axes and unit of its file.
        settings: what the user says of them.
        suffix: of the file's name, in lower case.
        subject: what an error names.

    Raises:
        UserError: no unit makes it as high as a building.
    """
    low, high = building.box
    size = high - low
    up, notes = _up(size, settings.up, suffix)
    metres, unit_notes = _unit(float(size[1 if up == "y" else 2]), settings.metres, suffix, subject)
    vertices = building.vertices.astype(np.float64) * metres
    if up == "y":
        vertices = np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1)
    return replace(building, vertices=vertices.astype(np.float32)).noted(*notes, *unit_notes)


def _up(size: FloatArray, chosen: Axis, suffix: str) -> tuple[str, list[str]]:
    if chosen != "auto":
        return chosen, []
    usual = "z" if suffix == ".ply" else "y"
    ratio = float(size[1]) / max(float(size[2]), 1e-12)
    found = "y" if ratio < 1 / _CLEARLY else "z" if ratio > _CLEARLY else usual
    if found == usual:
        return found, []
    return found, [f"{found} is taken for the upward axis, along which the mesh is shorter than along {usual}"]


def _unit(height: float, chosen: float | None, suffix: str, subject: object) -> tuple[float, list[str]]:
    if chosen is not None:
        return chosen, []
    if HEIGHTS[0] <= height <= HEIGHTS[1]:
        return 1.0, [] if suffix in _IN_METRES else [_TAKEN.format(name="metres", height=height)]
    heights = {name: height * metres for name, metres in _UNITS.items()}
    possible = [name for name, found in heights.items() if HEIGHTS[0] <= found <= HEIGHTS[1]]
    if possible:
        name = min(possible, key=lambda name: abs(math.log(heights[name] / _USUAL_HEIGHT)))
        return _UNITS[name], [_TAKEN.format(name=name, height=heights[name])]
    raise UserError(
        subject,
        f"is {height:g} units high, which is no building in metres, centimetres, millimetres, inches or feet",
        "say which axis points upwards (up) and how many metres its unit has (metres)",
    )
