"""Pictures as the page has them: small WebP files inside of a script."""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from PIL import Image

from avs.nvs.pictures import shrunk
from avs.report.page.page_settings import PageSettings
from avs.report.page.script_files import data_address

Pixels = npt.NDArray[np.uint8]


def picture(pixels: Pixels, settings: PageSettings) -> str:
    """Return an image ``[height, width]`` or ``[height, width, 3]`` as the address of a WebP picture."""
    stream = io.BytesIO()
    Image.fromarray(shrunk(pixels, settings.long_side)).save(stream, "WEBP", quality=settings.quality, method=2)
    return data_address(stream.getvalue(), "image/webp")


def pictures(found: Mapping[str, Pixels], settings: PageSettings) -> dict[str, str]:
    """Return images by name as addresses of WebP pictures."""
    return {name: picture(pixels, settings) for name, pixels in found.items()}
