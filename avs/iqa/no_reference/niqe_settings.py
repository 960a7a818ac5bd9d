"""How NIQE's parameters are fitted where the published ones are absent."""

from __future__ import annotations

from pydantic import Field

from avs.iqa.resizing import ResizeSettings
from avs.system.models import StrictModel


class PatchSettings(StrictModel):
    """Which patches of pristine pictures count."""

    patch: int = Field(default=96, ge=16, multiple_of=4, description="pixels of a patch's side, at the resized size")
    sharpness: float = Field(
        default=0.75, ge=0.0, le=1.0, description="least sharpness of a patch, relative to its image's sharpest one"
    )


class FitSettings(StrictModel):
    """All that the fit reads of the configuration."""

    resize: ResizeSettings = Field(default=ResizeSettings(), description="size of the pictures that the metric sees")
    fit: PatchSettings = Field(default=PatchSettings(), description="which patches count")
