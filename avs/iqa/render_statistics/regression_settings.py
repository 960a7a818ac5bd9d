"""Which statistics the regression of the true SSIM reads, and how it is fitted. Imports no torch."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, PositiveFloat

from avs.iqa.resizing import ResizeSettings
from avs.system.models import Different, StrictModel

Sight = Literal["opacity", "depth", "distance", "angle"]
"""What may be seen of a view beside the pixels of its rendering."""

COLUMNS: dict[Sight, tuple[str, ...]] = {
    "opacity": ("opacity",),
    "depth": ("depth", "depth_spread"),
    "distance": ("distance",),
    "angle": ("angle",),
}
"""The columns of ``avs.iqa.render_statistics.view_geometry`` that belong to each."""


class RegressionSettings(StrictModel):
    """All that the fit reads of the configuration."""

    resize: ResizeSettings = Field(
        default=ResizeSettings(), description="size of the renderings of which statistics are taken"
    )
    sees: Annotated[tuple[Sight, ...], Different] = Field(
        default=("opacity", "depth", "distance", "angle"),
        description="what is seen of a view beside the pixels of its rendering: accumulated opacity, depth, distance "
        "and angle to the nearest captured view; none of them makes it a method of pixels alone",
    )
    penalty: PositiveFloat = Field(
        default=1e-3, description="weight of the sum of squared coefficients of standardised statistics"
    )
