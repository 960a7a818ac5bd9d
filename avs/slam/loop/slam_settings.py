"""Everything that an exploration is made of."""

from __future__ import annotations

from pydantic import Field

from avs.slam.building.robot_camera import CameraSettings
from avs.slam.building.simulator import SimulatorSettings
from avs.slam.evaluation.map_quality import EvaluationSettings
from avs.slam.exploration.exploration_settings import ExplorationSettings
from avs.slam.mapping.mapper_settings import RELEASED_MAPPING, MapperSettings
from avs.slam.navigation.floor_map import AgentSettings
from avs.slam.navigation.robot_motion import MotionSettings
from avs.slam.scoring.path_choice import NearestSettings, PathScorerSettings
from avs.system.models import StrictModel

StartPose = tuple[float, float, float, float]
"""x, y and height of the floor in metres in the building's upright axes, and direction in degrees."""


class SlamSettings(StrictModel):
    """An exploration of a building. The defaults are those of FisherRF's mapping."""

    simulator: SimulatorSettings = Field(default=SimulatorSettings(), description="how the mesh is read and rendered")
    agent: AgentSettings = Field(default=AgentSettings(), description="the body of the robot")
    motion: MotionSettings = Field(default=MotionSettings(), description="sizes of its actions")
    camera: CameraSettings = Field(default=CameraSettings(), description="its camera")
    mapper: MapperSettings = Field(default=RELEASED_MAPPING, description="how the map is made")
    exploration: ExplorationSettings = Field(default=ExplorationSettings(), description="where it goes")
    scorer: PathScorerSettings = Field(default=NearestSettings(), description="what chooses a path")
    evaluation: EvaluationSettings = Field(default=EvaluationSettings(), description="what is measured")
    start: StartPose | None = Field(
        default=None,
        description="x, y, height of the floor (metres, z upwards) and direction (degrees); null: by chance on the "
        "largest floor, by the seed",
    )
