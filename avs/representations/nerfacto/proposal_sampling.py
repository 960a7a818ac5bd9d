"""Intervals of rays, placed where proposals have weight, and the two losses on them (arXiv 2111.12077, sections 3, 4).

Edges of intervals ``[rays, n + 1]`` are in the spacing of ``ray_fields.unbounded_space``, in 0..1 and ascending.
"""

from __future__ import annotations

import torch
from torch import Tensor

PADDING = 0.01
"""Added to the weight of each interval before new ones are drawn, in nerfstudio."""

EPSILON = 1e-7


def even_edges(rays: int, count: int, begin: float, end: float, offsets: Tensor) -> Tensor:
    """Return the edges of ``count`` intervals between begin and end, the inner ones moved by ``offsets`` ``[rays]``.

    Offsets are in 0..1 and the same for all edges of a ray; 0.5 moves none.
    """
    steps = torch.arange(count + 1, device=offsets.device, dtype=offsets.dtype)
    moved = (steps + (offsets[:, None] - 0.5)).clamp(0, count)
    moved[:, 0], moved[:, -1] = 0, count
    return begin + moved * ((end - begin) / count) + torch.zeros((rays, 1), device=offsets.device)


def drawn_edges(edges: Tensor, weights: Tensor, count: int, offsets: Tensor) -> Tensor:
    """Return the edges of ``count`` new intervals, dense where the old ones have weight; no gradients.

    Args:
        edges: of the old intervals, ``[rays, n + 1]``.
        weights: of the old intervals, ``[rays, n]``.
        count: of the new ones.
        offsets: ``[rays]`` in 0..1, which shift the places of the distribution at which edges are read.
    """
    padded = weights.detach() + PADDING
    cumulated = torch.cumsum(padded / padded.sum(dim=1, keepdim=True), dim=1)
    distribution = torch.cat([torch.zeros_like(cumulated[:, :1]), cumulated.clamp(max=1)], dim=1)
    steps = torch.arange(count + 1, device=edges.device, dtype=edges.dtype)
    wanted = (steps + offsets[:, None]) / (count + 1)
    above = torch.searchsorted(distribution, wanted.contiguous(), right=True).clamp(1, edges.shape[1] - 1)
    low, high = distribution.gather(1, above - 1), distribution.gather(1, above)
    first, second = edges.gather(1, above - 1), edges.gather(1, above)
    part = ((wanted - low) / (high - low).clamp_min(EPSILON)).clamp(0, 1)
    return (first + part * (second - first)).detach()


def weights_of(density: Tensor, lengths: Tensor) -> Tensor:
    """Return how much each interval shows, ``[rays, n]``, by density and length of each."""
    depth = density * lengths
    before = torch.exp(-(torch.cumsum(depth, dim=1) - depth))
    return before * (1 - torch.exp(-depth))


def interlevel_loss(edges: Tensor, weights: Tensor, outer_edges: Tensor, outer_weights: Tensor) -> Tensor:
    """Return by how much weights exceed what a proposal allows for them (arXiv 2111.12077, equation 13).

    Args:
        edges: of the field's intervals.
        weights: of the field's intervals, which get no gradients.
        outer_edges: of the proposal's intervals.
        outer_weights: of the proposal's intervals.
    """
    edges, weights = edges.detach(), weights.detach()
    cumulated = torch.cat([torch.zeros_like(outer_weights[:, :1]), torch.cumsum(outer_weights, dim=1)], dim=1)
    last = outer_weights.shape[1]
    before = torch.searchsorted(outer_edges, edges[:, :-1].contiguous(), right=True).sub(1).clamp(0, last)
    behind = torch.searchsorted(outer_edges, edges[:, 1:].contiguous()).clamp(0, last)
    bound = cumulated.gather(1, behind) - cumulated.gather(1, before)
    excess = (weights - bound).clamp_min(0)
    return torch.mean(excess**2 / (weights + EPSILON))


def distortion_loss(edges: Tensor, weights: Tensor) -> Tensor:
    """Return the mean over rays of how far their weights lie apart (arXiv 2111.12077, equation 15)."""
    middles, lengths = (edges[:, 1:] + edges[:, :-1]) / 2, edges.diff(dim=1)
    nearer = torch.cumsum(weights, dim=1) - weights
    reached = torch.cumsum(weights * middles, dim=1) - weights * middles
    between = 2 * (weights * (middles * nearer - reached)).sum(dim=1)
    return torch.mean(between + (weights**2 * lengths).sum(dim=1) / 3)
