"""Settings of the simulator."""

from __future__ import annotations

from pydantic import Field, PositiveInt

from avs.slam.building.building_frame import FrameSettings
from avs.system.models import StrictModel


class SimulatorSettings(StrictModel):
    """How a mesh is read and rendered."""

    frame: FrameSettings = Field(default=FrameSettings(), description="axes and unit of the mesh")
    samples: PositiveInt = Field(
        default=2, description="rays per pixel along each axis, of which the colour is the mean; depth is of the centre"
    )
