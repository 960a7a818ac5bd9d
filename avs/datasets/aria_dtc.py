"""Recordings of the Aria Digital Twin Catalogue, rectified, in either form of their cameras.

Meta's export (``egocentric_splats``) writes ``camera-rgb-rectified-*/transforms.json`` with OpenCV axes and, for the
pictures before they are rectified, ``camera-rgb-transforms.json``; nerfstudio's (``process_project_aria.py``) writes
``transforms.json`` with OpenGL axes. Pictures that are not rectified are undistorted here.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field, PositiveInt

from avs.datasets.nerfstudio import TransformsReader
from avs.datasets.transforms_file import PixelCenters


class AriaDtc(TransformsReader):
    """Recordings of the Aria Digital Twin Catalogue in a folder of the user's."""

    source: Literal["aria_dtc"] = Field(default="aria_dtc", description="Aria Digital Twin Catalogue")
    pixel_centers: PixelCenters = Field(
        default="integer", description="the centre of the first pixel: integer, (0, 0), as Aria's calibrations have it"
    )
    long_side: PositiveInt | None = Field(default=707, description="side of the images in pixels; the paper's is 707")

    def licence(self) -> str:
        """Return the terms of the pictures, one line."""
        return "the terms of the Digital Twin Catalogue, https://www.projectaria.com/datasets/dtc/"


READER = AriaDtc
