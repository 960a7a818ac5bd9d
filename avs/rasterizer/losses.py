"""The photometric loss of 3DGS: L1 and D-SSIM (arXiv 2308.04079, equation 7)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import conv2d

from avs.rasterizer.dssim import C1, C2, RADIUS, FloatArray, l1_dssim, target_moments, window


@dataclass(frozen=True)
class Target:
    """A photograph prepared for the loss.

    Attributes:
        image: ``[height, width, 3]`` float32 in 0..1, on the device of the optimisation.
        moments: on the CPU the window's mean of the image and of its square, which never change; None on other devices.
    """

    image: Tensor
    moments: tuple[FloatArray, FloatArray] | None


def prepare_target(image: np.ndarray[Any, np.dtype[np.uint8]], device: torch.device) -> Target:
    """Return the photograph ``[height, width, 3]`` uint8 as a target on ``device``."""
    values = image.astype(np.float32) / np.float32(255)
    moments = target_moments(values) if device.type == "cpu" else None
    return Target(torch.from_numpy(values).to(device), moments)


def photometric_loss(image: Tensor, target: Target, ssim_weight: float) -> Tensor:
    """Return ``(1 - ssim_weight) L1 + ssim_weight (1 - SSIM)``, a scalar.

    Both are means over pixels and channels; SSIM has an 11x11 Gaussian window of sigma 1.5 and zero padding. On the CPU
    value and gradient come from one fused kernel, elsewhere from ``conv2d``.

    Args:
        image: ``[height, width, 3]`` float32, a rendering.
        target: the photograph of the same size.
        ssim_weight: in 0..1.
    """
    if target.moments is not None:
        loss: Tensor = _FusedLoss.apply(image, target, ssim_weight)  # type: ignore[no-untyped-call]
        return loss
    absolute = (image - target.image).abs().mean()
    return (1 - ssim_weight) * absolute + ssim_weight * (1 - structural_similarity(image, target.image))


def structural_similarity(first: Tensor, second: Tensor) -> Tensor:
    """Return the mean SSIM of two images ``[height, width, 3]`` in 0..1, as a scalar, by ``conv2d``."""
    weights = torch.from_numpy(window()).to(first)
    kernel = torch.outer(weights, weights).expand(3, 1, -1, -1)
    x, y = (image.permute(2, 0, 1)[None] for image in (first, second))
    stacked = torch.cat([x, y, x * x, y * y, x * y])
    mean_x, mean_y, square_x, square_y, product = conv2d(stacked, kernel, padding=RADIUS, groups=3)
    variances = square_x - mean_x**2 + square_y - mean_y**2
    covariance = product - mean_x * mean_y
    similarity = (2 * mean_x * mean_y + C1) * (2 * covariance + C2)
    return torch.mean(similarity / ((mean_x**2 + mean_y**2 + C1) * (variances + C2)))


class _FusedLoss(torch.autograd.Function):
    """The CPU kernel as a differentiable function of the rendering."""

    @staticmethod
    def forward(
        ctx: Any,  # noqa: ANN401
        image: Tensor,
        target: Target,
        ssim_weight: float,
    ) -> Tensor:
        assert target.moments is not None
        value, gradient = l1_dssim(
            image.detach().contiguous().numpy(), target.image.numpy(), target.moments, ssim_weight
        )
        ctx.save_for_backward(torch.from_numpy(gradient))
        return image.new_tensor(value)

    @staticmethod
    def backward(
        ctx: Any,  # noqa: ANN401
        *gradients: Tensor,
    ) -> tuple[Tensor, None, None]:
        (gradient,) = ctx.saved_tensors
        return gradient * gradients[0], None, None
