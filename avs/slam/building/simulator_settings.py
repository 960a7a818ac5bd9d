"""Settings of the simulator."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, PositiveInt

from avs.slam.building.building_frame import FrameSettings
from avs.system.models import StrictModel


class SimulatorSettings(StrictModel):
    """How a mesh is read and rendered."""

    frame: FrameSettings = Field(default=FrameSettings(), description="axes and unit of the mesh")
    renderer: Literal["rays", "habitat"] = Field(
        default="rays",
        description="rays cast at the mesh; or Habitat-Sim, where it is installed, for the pictures, while floor, "
        "motion and what is measured stay those of the mesh",
    )
    samples: PositiveInt = Field(
        default=2,
        description="rays per pixel along each axis, of which the colour is the mean; depth is of the centre; of the "
        "renderer rays alone",
    )
