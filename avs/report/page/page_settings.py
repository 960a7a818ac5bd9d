"""What the configuration tells the page."""

from __future__ import annotations

from pydantic import Field, PositiveFloat, PositiveInt

from avs.system.models import StrictModel


class PageSettings(StrictModel):
    """What the page holds of pictures and models; its numbers are always complete."""

    megabytes: PositiveFloat = Field(
        default=50,
        description="limit of what the page holds of all scenes together, each by the number of its episodes; numbers "
        "come first, then photographs, then the lowest seeds, and what is left out says so",
    )
    long_side: PositiveInt = Field(default=320, description="pixels; larger pictures are made as small as that")
    quality: int = Field(default=70, ge=1, le=100, description="of the pictures, which are WebP files")
    gaussians: PositiveInt = Field(
        default=20_000, description="of a model; of a larger one, those that cover and hide the most"
    )
    points: PositiveInt = Field(default=4_000, description="of a scene or a cloud, evenly spread over its list")
