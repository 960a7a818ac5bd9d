"""Renderings and photographs as the input of an image quality method: type, size, batches.

torch is imported inside the functions, because selectors read the settings where torch is not wanted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from avs.system.models import StrictModel

if TYPE_CHECKING:
    from torch import Tensor

Pixels = npt.NDArray[np.uint8] | npt.NDArray[np.floating[Any]]

SMALLEST = 14
"""Pixels of the smallest side that an image is resized to: one token of the cross-reference network."""


class ResizeSettings(StrictModel):
    """How images are resized before they are scored; the aspect ratio stays."""

    side: Literal["long", "short"] = Field(
        default="long",
        description="the side that gets `pixels`: long as the paper says, short as CrossScore's code does",
    )
    pixels: int = Field(default=518, ge=SMALLEST, description="length of that side in pixels")


def target_size(height: int, width: int, settings: ResizeSettings) -> tuple[int, int]:
    """Return the height and width after resizing, rounded to the nearest pixel and at least ``SMALLEST``."""
    side = max(height, width) if settings.side == "long" else min(height, width)
    ratio = settings.pixels / side
    return max(SMALLEST, round(height * ratio)), max(SMALLEST, round(width * ratio))


def to_tensor(images: Pixels, device: str = "cpu") -> Tensor:
    """Return pixels as ``[n, 3, height, width]`` float32 in 0..1.

    Takes ``[n, height, width, 3]`` sRGB, uint8 or floats in 0..1. Floats outside 0..1, as a rasteriser may give them,
    are clipped.

    Raises:
        ValueError: the array has another shape.
    """
    if images.ndim != 4 or images.shape[-1] != 3:
        raise ValueError(f"images have shape {images.shape}, expected [n, height, width, 3]")
    import torch

    # The images may be read-only (frozen, or memory-mapped); torch would warn, though nothing here writes to them.
    tensor = torch.from_numpy(np.array(images) if not images.flags.writeable else images).to(device)
    floats = tensor.float() / 255.0 if tensor.dtype == torch.uint8 else tensor.float().clamp(0.0, 1.0)
    return floats.permute(0, 3, 1, 2)


def resized(images: Tensor, settings: ResizeSettings) -> Tensor:
    """Resize ``[n, channels, height, width]`` as CrossScore does: bilinear, antialiased where the size shrinks."""
    size = target_size(images.shape[-2], images.shape[-1], settings)
    if size == tuple(images.shape[-2:]):
        return images
    from torch.nn import functional

    return functional.interpolate(images, size, mode="bilinear", antialias=True)
