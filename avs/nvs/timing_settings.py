"""What is timed, and how often."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, PositiveFloat, PositiveInt

from avs.nvs.protocol import ProtocolSettings
from avs.representations.kinds import AnyRepresentationSettings
from avs.system.models import StrictModel


class RuntimeSettings(StrictModel):
    """The measurement of selection times."""

    scene: str | None = Field(
        default=None,
        description="scene on which selections are timed, by its name or as dataset/scene; null for the first of the "
        "first data set",
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


class StateSettings(StrictModel):
    """What the common reconstruction reads of the configuration."""

    device: Literal["cpu", "cuda"] = Field(description="where the reconstruction and networks run")
    protocol: ProtocolSettings = Field(description="the loop whose schedule the reconstruction follows")
    representation: AnyRepresentationSettings = Field(description="the reconstruction")
    runtime: RuntimeSettings = Field(description="what is timed")


class TimingSettings(StateSettings):
    """What the timing of a method reads of the configuration."""

    method: str = Field(description="identifier of the selection method")
    selector: dict[str, Any] = Field(description="settings of the method")
    views_per_step: PositiveInt = Field(description="views that the method chooses at once")
