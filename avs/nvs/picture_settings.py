"""Which pictures an episode keeps. Imports no torch, so that the workflow can read it quickly."""

from __future__ import annotations

from pydantic import Field, NonNegativeInt, PositiveInt

from avs.system.models import StrictModel

PICTURES = "pictures.zip"
"""Name of the archive of the pictures, in the folder of ``episode.json``."""


class PictureSettings(StrictModel):
    """Which pictures an episode keeps beside its record, for figures and pages; its numbers do not depend on them."""

    test_images: NonNegativeInt = Field(
        default=6, description="final renderings of so many test images, spread evenly over their names"
    )
    choices: bool = Field(
        default=True,
        description="rendering of each chosen view when it was chosen, the SSIM map that the method predicted of it, "
        "if it predicts any, and the true SSIM map",
    )
    long_side: PositiveInt = Field(default=640, description="pixels; larger pictures are made as small as that")
    quality: int = Field(default=90, ge=1, le=100, description="of JPEG, with colours at full resolution")
