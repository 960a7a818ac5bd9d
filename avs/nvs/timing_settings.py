"""What is timed, and how often."""

from __future__ import annotations

from pydantic import Field, PositiveFloat, PositiveInt

from avs.system.models import StrictModel


class RuntimeSettings(StrictModel):
    """The measurement of selection times."""

    scene: str | None = Field(
        default=None, description="scene on which selections are timed; null for the first of the first data set"
    )
    seed: int = Field(default=0, description="seed of the reconstruction and of random choices")
    views: PositiveInt = Field(
        default=12, description="views captured when a selection is timed; one less than the budget where that is less"
    )
    repeats: PositiveInt = Field(default=3, description="timed selections of each method")
    seconds: PositiveFloat = Field(
        default=20.0,
        description="no further selection of a method begins after so many seconds, but one is always timed",
    )
