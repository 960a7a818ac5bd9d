"""How an unbounded scene fits into a bounded grid, and how far apart samples of a ray lie.

Space is contracted as in Mip-NeRF 360 (arXiv 2111.12077, equation 10), with the largest coordinate in the place of the
Euclidean norm, as in Nerfacto (arXiv 2302.04264), so that what is contracted fills a cube: the cube of a half
side of 1 around the middle stays as it is, everything beyond lies between it and the cube of a half side of 2.
"""

from __future__ import annotations

import torch
from torch import Tensor

BALL = 1.1
"""The scene extent is this many times the distance of the farthest camera, which is the inner box's half side."""


def contracted(points: Tensor) -> Tensor:
    """Return points ``[..., 3]``, in units of the inner cube's half side, contracted into -2..2."""
    largest = points.abs().amax(dim=-1, keepdim=True)
    outside = largest.clamp_min(1)
    return torch.where(largest > 1, (2 - 1 / outside) * (points / outside), points)


def spacing_of(distances: Tensor, turn: float) -> Tensor:
    """Return where distances lie in 0..1: evenly up to ``turn``, which is at 0.5, and evenly in 1 / distance beyond."""
    relative = distances / turn
    return torch.where(relative < 1, relative / 2, 1 - 0.5 / relative.clamp_min(1))


def distance_at(spacing: Tensor, turn: float) -> Tensor:
    """Return the inverse of ``spacing_of``."""
    return turn * torch.where(spacing < 0.5, 2 * spacing, 0.5 / (1 - spacing).clamp_min(1e-6))
