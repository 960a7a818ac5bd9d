"""The body of a robot, and its actions."""

from __future__ import annotations

from pydantic import Field, NonNegativeFloat, PositiveFloat

from avs.system.models import StrictModel


class AgentSettings(StrictModel):
    """The body of a robot; the defaults are Habitat's."""

    radius: PositiveFloat = Field(default=0.1, description="of its body, metres")
    height: PositiveFloat = Field(default=1.5, description="of its body, metres")
    step: NonNegativeFloat = Field(default=0.2, description="greatest height that it climbs at once, metres")
    cell: PositiveFloat = Field(default=0.05, description="edge of a cell of the map of the floor, metres")
    least_island: PositiveFloat = Field(default=1.0, description="area of floor that is worth exploring, square metres")


class MotionSettings(StrictModel):
    """Sizes of the actions; the defaults are those of FisherRF's mapping."""

    forward: PositiveFloat = Field(default=0.05, description="metres of one action forward")
    turn: float = Field(default=5.0, gt=0, le=45, description="degrees of one turn")
