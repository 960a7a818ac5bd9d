"""Hashed grids of features (Müller et al. 2022, arXiv 2201.05989) as differentiable functions of their tables."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import torch
from torch import Tensor

from avs.representations.nerfacto import hash_grid_kernels
from avs.representations.nerfacto.hash_grid_kernels import PRIME_Y, PRIME_Z
from avs.representations.nerfacto.nerfacto_settings import HashGrid

FEATURES = 2
"""Numbers of an entry (arXiv 2201.05989, section 4)."""

INITIAL_SIZE = 1e-4
"""Entries are drawn evenly from minus this to this at the start (arXiv 2201.05989, section 4)."""


def initial_tables(grid: HashGrid, generator: np.random.Generator) -> Tensor:
    """Return untrained tables ``[levels, entries, 2]``."""
    shape = (grid.levels, 2**grid.log2_entries, FEATURES)
    return torch.from_numpy(generator.uniform(-INITIAL_SIZE, INITIAL_SIZE, shape).astype(np.float32))


def cells_of(grid: HashGrid) -> tuple[int, ...]:
    """Return the cells a side of each level."""
    if grid.levels == 1:
        return (grid.coarsest,)
    growth = math.log(grid.finest / grid.coarsest) / (grid.levels - 1)
    return tuple(math.floor(grid.coarsest * math.exp(level * growth) + 1e-6) for level in range(grid.levels))


def looked_up(tables: Tensor, cells: tuple[int, ...], places: Tensor) -> Tensor:
    """Return the features of all levels at places ``[n, 3]`` in -2..2, ``[n, 2 * levels]``."""
    if tables.device.type == "cpu" and tables.dtype == torch.float32:
        found: Tensor = _LookedUp.apply(tables, cells, places)  # type: ignore[no-untyped-call]
        return found
    return looked_up_by_torch(tables, cells, places)


def looked_up_by_torch(tables: Tensor, cells: tuple[int, ...], places: Tensor) -> Tensor:
    """Do the same with torch alone: for CUDA, and as the reference of tests in float64."""
    levels, entries, _ = tables.shape
    found = []
    for level in range(levels):
        side = cells[level] + 1
        position = (places + 2) / 4 * cells[level]
        lower = position.detach().long().clamp(0, cells[level] - 1)
        part = position - lower
        total = torch.zeros((), device=tables.device, dtype=tables.dtype)
        for corner in range(8):
            upper = torch.tensor([corner >> 2, (corner >> 1) & 1, corner & 1], device=tables.device)
            weight = torch.where(upper > 0, part, 1 - part).prod(dim=1)
            i, j, k = (lower + upper).unbind(dim=1)
            entry = (i * side + j) * side + k
            if side**3 > entries:
                entry = (i ^ (j * PRIME_Y) ^ (k * PRIME_Z)) & (entries - 1)
            total = total + weight[:, None] * tables[level, entry]
        found.append(total)
    return torch.cat(found, dim=1)


class _LookedUp(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any,  # noqa: ANN401
        tables: Tensor,
        cells: tuple[int, ...],
        places: Tensor,
    ) -> Tensor:
        sides = np.array(cells)
        ctx.found = (tuple(tables.shape), sides, places.detach().contiguous().numpy())
        return torch.from_numpy(hash_grid_kernels.looked_up(tables.detach().numpy(), sides, ctx.found[2]))

    @staticmethod
    def backward(
        ctx: Any,  # noqa: ANN401
        *gradients: Tensor,
    ) -> tuple[Tensor | None, ...]:
        found = hash_grid_kernels.looked_up_backward(*ctx.found, gradients[0].contiguous().numpy())
        return torch.from_numpy(found), None, None
