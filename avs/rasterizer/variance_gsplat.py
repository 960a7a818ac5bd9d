"""Rendered variance on CUDA, from gsplat's public functions.

gsplat blends colours with weights, not with their squares. It does list the Gaussians that it blended into each pixel,
from near to far (``rasterize_to_indices_in_range``); from these pairs the weights are computed again by torch, and
autograd differentiates them. A pair takes about a hundred bytes: 5 GB for the 1.7 million pixels of a photograph of
1600x1066 with thirty Gaussians each.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import gsplat
import torch
from torch import Tensor

from avs.rasterizer.constants import ALPHA_MAX

NEVER_STOPS = 1e30
"""A transmittance to begin with that no Gaussian brings down to where a pixel stops."""


@dataclass(frozen=True)
class Pairs:
    """The Gaussians blended into the pixels: by image, pixel (row-major) and then depth.

    Attributes:
        images: ``[M]`` int64.
        pixels: ``[M]`` int64, within the image.
        gaussians: ``[M]`` int64.
    """

    images: Tensor
    pixels: Tensor
    gaussians: Tensor


def rasterization_with_variance(
    means: Tensor,
    quats: Tensor,
    scales: Tensor,
    opacities: Tensor,
    colors: Tensor,
    variances: Tensor,
    viewmats: Tensor,
    Ks: Tensor,
    width: int,
    height: int,
    sh_degree: int,
    absgrad: bool,
    backgrounds: Tensor,
    attenuated: bool,
) -> tuple[Tensor, Tensor, dict[str, Any]]:
    """Do what ``variance_rasterization.rasterization_with_variance`` does, on CUDA tensors."""
    images, _, meta = gsplat.rasterization(
        means, quats, scales, opacities, colors, viewmats, Ks, width, height,
        sh_degree=sh_degree, packed=False, absgrad=absgrad, backgrounds=backgrounds,
    )  # fmt: skip
    pairs = blended_pairs(meta)
    alphas, light = blending(meta, pairs)
    squares = (alphas * light) ** 2
    of_pairs = variances[pairs.gaussians]
    if attenuated:
        squares = squares.detach()
        of_pairs = of_pairs + (of_pairs * ((1 - alphas) ** 2 - 1)).detach()
    return images, _sum_by_pixel(squares * of_pairs, pairs, meta), meta


@torch.no_grad()
def variance_reduction(
    means: Tensor,
    quats: Tensor,
    scales: Tensor,
    opacities: Tensor,
    variances: Tensor,
    viewmat: Tensor,
    intrinsics: Tensor,
    width: int,
    height: int,
    attenuated: bool,
    constant: float,
    weighted: bool,
    saturated: bool,
) -> float:
    """Do what ``variance_rasterization.variance_reduction`` does, on CUDA tensors."""
    _, _, meta = gsplat.rasterization(
        means, quats, scales, opacities, means.new_zeros(len(means), 1), viewmat[None], intrinsics[None], width, height,
        packed=False, render_mode="D",
    )  # fmt: skip
    pairs = blended_pairs(meta)
    beta = variances[pairs.gaussians]
    alphas, light = blending(meta, pairs)
    spread = beta * (alphas * light * (1 - alphas if attenuated else 1)) ** 2
    prior = (constant + _sum_by_pixel(spread, pairs, meta)).flatten()
    part = spread / (prior[pairs.pixels] + spread)
    if saturated:
        part = torch.where(stopped_pixels(meta, pairs)[pairs.pixels], 1.0, part)
    reduction = (spread if weighted else beta) * part
    return float(reduction.sum(dtype=torch.float64)) + weighted * constant * width * height


def blended_pairs(meta: dict[str, Any], transmittance: float = 1.0) -> Pairs:
    """Return the pairs of what ``gsplat.rasterization`` rendered with ``packed=False``.

    Args:
        meta: what it returned.
        transmittance: that each pixel begins with.
    """
    means2d, offsets, ids = meta["means2d"].detach(), meta["isect_offsets"], meta["flatten_ids"]
    shape = (len(means2d), meta["height"], meta["width"])
    gaussians, pixels, images = gsplat.rasterize_to_indices_in_range(
        0,
        # a batch is tile_size^2 Gaussians of one tile's list; this many hold all lists
        len(ids) // meta["tile_size"] ** 2 + 1,
        torch.full(shape, transmittance, device=means2d.device),
        means2d,
        meta["conics"].detach(),
        meta["opacities"].detach(),
        meta["width"],
        meta["height"],
        meta["tile_size"],
        offsets,
        ids,
    )
    return Pairs(images, pixels, gaussians)


def blending(meta: dict[str, Any], pairs: Pairs) -> tuple[Tensor, Tensor]:
    """Return the opacity alpha_i ``[M]`` of each pair and the transmittance T_i ``[M]`` in front of it.

    Differentiable in the centres, conics and opacities of ``meta``. Logarithms of transmittances are summed over all
    pairs in float64, of which the sum before each pixel's first pair is taken off.
    """
    at = (pairs.images, pairs.gaussians)
    x, y = (pairs.pixels % meta["width"] + 0.5), (pairs.pixels // meta["width"] + 0.5)
    dx, dy = (torch.stack([x, y], dim=-1) - meta["means2d"][at]).unbind(-1)
    a, b, c = meta["conics"][at].unbind(-1)
    power = 0.5 * (a * dx * dx + c * dy * dy) + b * dx * dy
    alphas = (meta["opacities"][at] * torch.exp(-power)).clamp(max=ALPHA_MAX)
    logarithms = torch.log1p(-alphas.double())
    before = logarithms.cumsum(0) - logarithms
    _, lengths = torch.unique_consecutive(_rays(pairs, meta), return_counts=True)
    first = lengths.cumsum(0) - lengths
    light = (before - torch.repeat_interleave(before[first], lengths)).exp().to(alphas.dtype)
    return alphas, light


def stopped_pixels(meta: dict[str, Any], pairs: Pairs) -> Tensor:
    """Return, for each pixel of one image, whether it stopped before its last Gaussian, ``[H W]`` bool.

    It did if more Gaussians would have been blended into it had there been no end.
    """
    size: int = meta["height"] * meta["width"]
    every = blended_pairs(meta, NEVER_STOPS)
    return torch.bincount(every.pixels, minlength=size) > torch.bincount(pairs.pixels, minlength=size)


def _rays(pairs: Pairs, meta: dict[str, Any]) -> Tensor:
    """Return the number of each pair's pixel among those of all images, ``[M]``."""
    size: int = meta["height"] * meta["width"]
    return pairs.images * size + pairs.pixels


def _sum_by_pixel(values: Tensor, pairs: Pairs, meta: dict[str, Any]) -> Tensor:
    """Return the sums of ``values [M]`` over the pairs of each pixel, ``[C, H, W]``."""
    shape: tuple[int, int, int] = (len(meta["means2d"]), meta["height"], meta["width"])
    sums: Tensor = values.new_zeros(shape[0] * shape[1] * shape[2]).index_add(0, _rays(pairs, meta), values)
    return sums.reshape(shape)
