"""How NIQE's parameters are fitted where the published ones are absent."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from avs.iqa.resizing import ResizeSettings


class RefitSettings(BaseModel):
    """Which patches of pristine pictures count."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    patch: int = Field(default=96, ge=16, multiple_of=4, description="pixels of a patch's side, at the resized size")
    sharpness: float = Field(
        default=0.75, ge=0.0, le=1.0, description="least sharpness of a patch, relative to its image's sharpest one"
    )


class FitSettings(BaseModel):
    """All that the fit reads of the configuration."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    resize: ResizeSettings = Field(default=ResizeSettings(), description="size of the pictures that the metric sees")
    refit: RefitSettings = Field(default=RefitSettings(), description="which patches count")
