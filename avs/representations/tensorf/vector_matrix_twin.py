"""What ``vector_matrix_kernels`` computes, with torch alone: for CUDA, and as the reference of tests in float64."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import grid_sample, softplus

from avs.representations.ray_fields.unbounded_space import contracted, distance_at


def products(planes: Tensor, lines: Tensor, places: Tensor) -> Tensor:
    """Return plane times line of each mode and component at places ``[m, 3]``, as ``[m, 3 * components]``."""
    found = []
    for mode in range(3):
        first, second, along = (places[:, (mode + turn) % 3] / 2 for turn in range(3))
        # grid_sample's x is the last axis of the image.
        at = torch.stack([second, first], dim=1)[None, :, None]
        plane = grid_sample(planes[mode].permute(2, 0, 1)[None], at, align_corners=True, padding_mode="border")
        at = torch.stack([torch.zeros_like(along), along], dim=1)[None, :, None]
        line = grid_sample(lines[mode].T[None, :, :, None], at, align_corners=True, padding_mode="border")
        found.append((plane * line)[0, :, :, 0].T)
    return torch.cat(found, dim=1)


def march(
    planes: Tensor,
    lines: Tensor,
    filled: Tensor,
    origins: Tensor,
    directions: Tensor,
    offsets: Tensor,
    numbers: tuple[float, float, float, float, float],
    samples: int,
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Do what the kernel does, and return places ``[m, 3]``, rays ``[m]``, distances ``[m]`` and weights ``[m]``."""
    near, turn, shift, scale, least = numbers
    begin = near / (2 * turn)
    edges = begin + torch.arange(samples + 1, dtype=origins.dtype, device=origins.device) * ((1 - begin) / samples)
    spacing = edges[:-1] + offsets[:, None] * ((1 - begin) / samples)
    distances, lengths = distance_at(spacing, turn), distance_at(edges, turn).diff() * scale
    places = contracted(origins[:, None] + distances[..., None] * directions[:, None])
    size = filled.shape[0]
    cells = ((places + 2) / 4 * size).long().clamp(0, size - 1)
    taken = filled[cells[..., 0], cells[..., 1], cells[..., 2]] > 0
    rays = torch.arange(len(origins), device=origins.device)[:, None].expand_as(taken)
    density = torch.zeros_like(distances)
    density[taken] = softplus(products(planes, lines, places[taken]).sum(dim=1) + shift)
    depth = density * lengths
    before = torch.exp(-(depth.cumsum(dim=1) - depth))
    weights = before * (1 - torch.exp(-depth))
    taken = taken & (before >= least)
    return places[taken], rays[taken], distances[taken], weights[taken]
