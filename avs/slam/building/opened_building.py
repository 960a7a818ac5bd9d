"""A mesh file as a building to look at, by the renderer that the settings name."""

from __future__ import annotations

from pathlib import Path

from avs.slam.building.building_files import read_building
from avs.slam.building.building_frame import upright
from avs.slam.building.habitat_simulator import HabitatSimulator
from avs.slam.building.simulator import Simulator
from avs.slam.building.simulator_settings import SimulatorSettings


def open_simulator(path: Path, settings: SimulatorSettings) -> Simulator:
    """Return the simulator of a mesh file.

    Raises:
        UserError: the mesh cannot be read, is as high as no building, or the renderer cannot be had.
    """
    raw = read_building(path)
    building = upright(raw, settings.frame, path.suffix.lower(), path)
    if settings.renderer == "habitat":
        return HabitatSimulator(path, raw, building)
    return Simulator(building, settings.samples)
