"""Samples and lookups as differentiable functions of planes and lines: the kernels on the CPU, else their twins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from avs.representations.tensorf import vector_matrix_kernels, vector_matrix_twin


@dataclass(frozen=True)
class March:
    """What taking samples depends on beside the field.

    Attributes:
        filled: ``[cells, cells, cells]`` uint8, 0 where no samples are to be taken.
        near: where rays begin, in units of the inner box's half side.
        turn: where the spacing turns from even in distance to even in its inverse.
        shift: added to the density before the softplus.
        scale: factor of the density.
        least: transmittance at which a ray ends.
        samples: intervals of each ray.
    """

    filled: Tensor
    near: float
    turn: float
    shift: float
    scale: float
    least: float
    samples: int

    @property
    def numbers(self) -> tuple[float, float, float, float, float]:
        """The numbers that the kernel takes."""
        return (self.near, self.turn, self.shift, self.scale, self.least)


Samples = tuple[Tensor, Tensor, Tensor, Tensor]
"""m samples: places ``[m, 3]`` in the contracted cube, rays ``[m]`` int64, distances ``[m]`` and weights ``[m]``."""


def marched(
    planes: Tensor, lines: Tensor, origins: Tensor, directions: Tensor, offsets: Tensor, march: March
) -> Samples:
    """Return the samples of rays; the weights have gradients.

    Args:
        planes: of the density, ``[3, cells, cells, components]``.
        lines: of the density, ``[3, cells, components]``.
        origins: ``[n, 3]`` in units of the inner box's half side.
        directions: ``[n, 3]``, of length 1.
        offsets: ``[n]`` in 0..1, where in its interval each sample of a ray lies.
        march: all else.
    """
    if planes.device.type == "cpu" and planes.dtype == torch.float32:
        samples: Samples = _March.apply(planes, lines, origins, directions, offsets, march)  # type: ignore[no-untyped-call]
        return samples
    return vector_matrix_twin.march(
        planes, lines, march.filled, origins, directions, offsets, march.numbers, march.samples
    )


def products(planes: Tensor, lines: Tensor, places: Tensor) -> Tensor:
    """Return plane times line of each mode and component at places ``[m, 3]``, as ``[m, 3 * components]``."""
    if planes.device.type == "cpu" and planes.dtype == torch.float32:
        found: Tensor = _Products.apply(planes, lines, places)  # type: ignore[no-untyped-call]
        return found
    return vector_matrix_twin.products(planes, lines, places)


class _March(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any,  # noqa: ANN401
        planes: Tensor,
        lines: Tensor,
        origins: Tensor,
        directions: Tensor,
        offsets: Tensor,
        march: March,
    ) -> Samples:
        places, rays, table, starts = vector_matrix_kernels.march(
            *(each.detach().numpy() for each in (planes, lines, march.filled, origins, directions, offsets)),
            tuple(np.float32(each) for each in march.numbers),
            march.samples,
        )
        ctx.save_for_backward(planes, lines)
        ctx.found = (places, table, starts)
        found = tuple(map(torch.from_numpy, (places, rays, table[0], table[3])))
        ctx.mark_non_differentiable(*found[:3])
        return found[0], found[1], found[2], found[3]

    @staticmethod
    def backward(
        ctx: Any,  # noqa: ANN401
        *gradients: Tensor,
    ) -> tuple[Tensor | None, ...]:
        planes, lines = ctx.saved_tensors
        found = vector_matrix_kernels.march_backward(
            planes.detach().numpy(), lines.detach().numpy(), *ctx.found, gradients[3].contiguous().numpy()
        )
        return (*map(torch.from_numpy, found), None, None, None, None)


class _Products(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any,  # noqa: ANN401
        planes: Tensor,
        lines: Tensor,
        places: Tensor,
    ) -> Tensor:
        ctx.save_for_backward(planes, lines, places)
        arrays = (each.detach().contiguous().numpy() for each in (planes, lines, places))
        return torch.from_numpy(vector_matrix_kernels.products(*arrays))

    @staticmethod
    def backward(
        ctx: Any,  # noqa: ANN401
        *gradients: Tensor,
    ) -> tuple[Tensor | None, ...]:
        arrays = (each.detach().contiguous().numpy() for each in (*ctx.saved_tensors, gradients[0]))
        return (*map(torch.from_numpy, vector_matrix_kernels.products_backward(*arrays)), None)
