"""Everything that an exploration is made of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

from pydantic import Field, field_validator, model_validator

from avs.slam.building.robot_camera import CameraSettings
from avs.slam.building.simulator_settings import SimulatorSettings
from avs.slam.evaluation.evaluation_settings import EvaluationSettings
from avs.slam.exploration.exploration_settings import ExplorationSettings
from avs.slam.mapping.mapper_settings import RELEASED_MAPPING, MapperSettings
from avs.slam.navigation.agent_settings import AgentSettings, MotionSettings
from avs.slam.scoring.path_settings import NearestSettings, PathScorerSettings
from avs.system.models import StrictModel, laid_over

StartPose = tuple[float, float, float, float]
"""x, y and height of the floor in metres in the building's upright axes, and direction in degrees."""


class RobotSettings(StrictModel):
    """What all explorations of a run have in common. The defaults are those of FisherRF's mapping."""

    simulator: SimulatorSettings = Field(default=SimulatorSettings(), description="how the mesh is read and rendered")
    agent: AgentSettings = Field(default=AgentSettings(), description="the body of the robot")
    motion: MotionSettings = Field(default=MotionSettings(), description="sizes of its actions")
    camera: CameraSettings = Field(default=CameraSettings(), description="its camera")
    mapper: MapperSettings = Field(
        default=RELEASED_MAPPING, description="how the map is made; what is left out is as in FisherRF's mapping"
    )
    exploration: ExplorationSettings = Field(default=ExplorationSettings(), description="where it goes")
    evaluation: EvaluationSettings = Field(default=EvaluationSettings(), description="what is measured")

    @field_validator("mapper", mode="before")
    @classmethod
    def _over_the_released(cls, value: object) -> object:
        """One key of a section must not change the others: MapperSettings' own defaults are SplaTAM's."""
        return laid_over(RELEASED_MAPPING.model_dump(), value) if isinstance(value, Mapping) else value

    @model_validator(mode="after")
    def _camera_on_the_body(self) -> Self:
        if self.camera.above_floor > self.agent.height:
            raise ValueError("camera.above_floor is higher than agent.height, so that it would pass through things")
        return self


class SlamSettings(RobotSettings):
    """An exploration of a building."""

    scorer: PathScorerSettings = Field(default=NearestSettings(), description="what chooses a path")
    start: StartPose | None = Field(
        default=None,
        description="x, y, height of the floor (metres, z upwards) and direction (degrees); null: by chance on the "
        "largest floor, by the seed",
    )
