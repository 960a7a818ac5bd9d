"""Nine numbers that say how a rendering looks: brightness, colour, and how much detail it has at which size."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from avs.iqa.resizing import Pixels, ResizeSettings, resized, to_tensor

if TYPE_CHECKING:
    from torch import Tensor

PIXEL_STATISTICS = (
    "brightness",
    "contrast",
    "saturation",
    "gradient",
    "gradient_half",
    "gradient_quarter",
    "laplacian",
    "sharpness_spread",
    "flat",
)
"""Their names, in order."""

_LUMINANCE = (0.299, 0.587, 0.114)
_LEAST = 1e-3
"""Added before a logarithm: a quarter of the smallest step of eight bits."""

_FLAT = 0.01
"""Gradient below which a pixel has no detail: two and a half steps of eight bits."""


def pixel_statistics(images: Pixels, resize: ResizeSettings) -> npt.NDArray[np.float64]:
    """Return the statistics of each image.

    Brightness and contrast are mean and standard deviation of the luminance in 0..1, saturation is the mean of the
    greatest less the least channel. ``gradient`` is the logarithm of the mean length of the luminance's gradient at
    full, half and a quarter of the size, ``laplacian`` that of the mean absolute Laplacian, ``sharpness_spread`` that
    of the root mean square gradient over the mean one, which is large where a sharp part stands before a blurred one;
    ``flat`` is the share of pixels without detail.

    Args:
        images: ``[n, height, width, 3]`` sRGB, uint8 or floats in 0..1.
        resize: size that they are brought to first, at least 14 pixels a side.

    Returns:
        ``[n, 9]``, finite; columns as ``PIXEL_STATISTICS``.
    """
    import torch

    with torch.inference_mode():
        pixels = resized(to_tensor(images), resize).clamp(0.0, 1.0)
        grey = (pixels * pixels.new_tensor(_LUMINANCE).view(3, 1, 1)).sum(dim=1, keepdim=True)
        sizes = [grey, *(torch.nn.functional.avg_pool2d(grey, factor) for factor in (2, 4))]
        lengths = [_gradient(each) for each in sizes]
        means = [each.mean(dim=(1, 2)) for each in lengths]
        root = lengths[0].square().mean(dim=(1, 2)).sqrt()
        columns = [
            grey.mean(dim=(1, 2, 3)),
            grey.flatten(1).std(dim=1, correction=0),
            (pixels.amax(dim=1) - pixels.amin(dim=1)).mean(dim=(1, 2)),
            *((mean + _LEAST).log() for mean in means),
            (_laplacian(grey).abs().mean(dim=(1, 2)) + _LEAST).log(),
            ((root + _LEAST) / (means[0] + _LEAST)).log(),
            (lengths[0] < _FLAT).float().mean(dim=(1, 2)),
        ]
        statistics: npt.NDArray[np.float64] = torch.stack(columns, dim=1).double().numpy()
    return statistics


def _gradient(grey: Tensor) -> Tensor:
    """Return the length of the gradient by forward differences, ``[n, height - 1, width - 1]``."""
    down = grey[:, 0, 1:, :-1] - grey[:, 0, :-1, :-1]
    right = grey[:, 0, :-1, 1:] - grey[:, 0, :-1, :-1]
    return (down.square() + right.square()).sqrt()


def _laplacian(grey: Tensor) -> Tensor:
    """Return the Laplacian by the five-point stencil, ``[n, height - 2, width - 2]``."""
    image = grey[:, 0]
    around = image[:, 2:, 1:-1] + image[:, :-2, 1:-1] + image[:, 1:-1, 2:] + image[:, 1:-1, :-2]
    return around - 4.0 * image[:, 1:-1, 1:-1]
