"""How captures become scenes."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, PositiveInt, model_validator

from avs.system.models import Color, StrictModel


class CaptureSettings(StrictModel):
    """Image size and split of captures in COLMAP layout."""

    long_side: PositiveInt | None = Field(
        default=480, description="longer side of the images in pixels; smaller images stay as they are; null: no limit"
    )
    short_side: PositiveInt | None = Field(default=None, description="the shorter side, in place of long_side")
    resample: Literal["pil", "area"] = Field(
        default="pil",
        description="filter for smaller images: Pillow's default, an antialiased bicubic (3DGS), or the mean over area",
    )
    test_every: int = Field(
        default=8, ge=2, description="every n-th image by name, starting with the first, is a test image (LLFF: 8)"
    )
    background: Color | None = Field(
        default=None,
        description="sRGB colour in 0..1 behind transparent pixels; null for the background of the representation",
    )

    @model_validator(mode="after")
    def _one_size(self) -> Self:
        if self.long_side is not None and self.short_side is not None:
            raise ValueError("give long_side or short_side; set the other to null")
        return self

    def image_size(self, width: int, height: int) -> tuple[int, int]:
        """Return the size to which an image of ``width`` x ``height`` pixels is resized; it is never enlarged."""
        limit, side = self.long_side, max(width, height)
        if self.short_side is not None:
            limit, side = self.short_side, min(width, height)
        if limit is None or side <= limit:
            return width, height
        return max(1, round(width * limit / side)), max(1, round(height * limit / side))
