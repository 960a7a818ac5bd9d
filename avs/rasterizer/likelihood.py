"""The likelihood of a photograph under a rendering with a variance for each pixel (arXiv 2209.08546)."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from torch import Tensor

from avs.rasterizer.kernels import Floats, kernel


def negative_log_likelihood(image: Tensor, variance: Tensor, photograph: Tensor, floor: float) -> Tensor:
    """Return the mean over pixels and channels of ``(C - C')^2 / (2 V) + log(V) / 2``, a scalar.

    V is the variance or the floor, whichever is larger; below the floor no gradient flows to the variance. The constant
    ``log(2 pi) / 2`` of a normal distribution is left out. On the CPU value and gradients come from one fused kernel.

    Args:
        image: ``[height, width, 3]`` float32, a rendering.
        variance: ``[height, width]`` float32, of each channel.
        photograph: of the image's size.
        floor: positive.
    """
    if image.is_cuda:
        held = variance.clamp(min=floor)[..., None]
        return ((image - photograph) ** 2 / (2 * held) + held.log() / 2).mean()
    value: Tensor = _Fused.apply(image, variance, photograph, floor)  # type: ignore[no-untyped-call]
    return value


class _Fused(torch.autograd.Function):
    """The CPU kernel as a differentiable function of rendering and variance."""

    @staticmethod
    def forward(
        ctx: Any,  # noqa: ANN401
        image: Tensor,
        variance: Tensor,
        photograph: Tensor,
        floor: float,
    ) -> Tensor:
        arrays = [tensor.detach().contiguous().numpy() for tensor in (image, variance, photograph)]
        value, v_image, v_variance = _value_and_gradients(*arrays, floor)
        ctx.save_for_backward(torch.from_numpy(v_image), torch.from_numpy(v_variance))
        return image.new_tensor(value)

    @staticmethod
    def backward(
        ctx: Any,  # noqa: ANN401
        *gradients: Tensor,
    ) -> tuple[Tensor, Tensor, None, None]:
        v_image, v_variance = ctx.saved_tensors
        return v_image * gradients[0], v_variance * gradients[0], None, None


@kernel
def _value_and_gradients(
    image: Floats, variance: Floats, photograph: Floats, floor: float
) -> tuple[float, Floats, Floats]:
    """Return the mean, summed in float64, and its gradients by image and variance."""
    height, width, channels = image.shape
    v_image, v_variance = np.empty_like(image), np.zeros_like(variance)
    scale, at_floor, log_floor = 1.0 / image.size, 1.0 / floor, np.log(floor)
    total = 0.0
    for row in range(height):
        for column in range(width):
            value = np.float64(variance[row, column])
            above = value >= floor
            inverse = 1.0 / value if above else at_floor
            squares = 0.0
            for channel in range(channels):
                difference = np.float64(image[row, column, channel]) - np.float64(photograph[row, column, channel])
                squares += difference * difference
                v_image[row, column, channel] = scale * inverse * difference
            total += 0.5 * (squares * inverse + channels * (np.log(value) if above else log_floor))
            if above:
                v_variance[row, column] = 0.5 * scale * inverse * (channels - squares * inverse)
    return total * scale, v_image, v_variance
