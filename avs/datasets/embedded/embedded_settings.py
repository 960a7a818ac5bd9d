"""Settings of the embedded scenes."""

from __future__ import annotations

from pydantic import Field

from avs.system.models import StrictModel


class EmbeddedSettings(StrictModel):
    """How large and how fine an embedded scene is made. What it shows depends on the pattern and the seed alone."""

    views: int = Field(64, ge=8, le=1024, description="number of images, test images (every 8th by name) included")
    long_side: int = Field(192, ge=16, le=4096, description="long side of the images in pixels")
    samples_per_axis: int = Field(
        2, ge=2, le=8, description="stratified samples per pixel along each axis: 2 gives 4 samples per pixel"
    )
    texture_levels: int = Field(
        8, ge=6, le=11, description="textures have 2 to this power texels along each side: 8 gives 256 x 256"
    )
    gather_rays: int = Field(
        24, ge=8, le=1024, description="rays per vertex that gather light from the sky and from other surfaces"
    )
    bounces: int = Field(2, ge=0, le=8, description="bounces of light between surfaces before it reaches the camera")
    points: int = Field(3000, ge=0, description="greatest number of sparse points")
    point_noise: float = Field(
        0.3, ge=0, description="standard deviation of a sparse point's error, in pixels of its observations"
    )
