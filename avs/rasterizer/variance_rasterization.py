"""Rendered variance: each Gaussian's variance blended with the square of its weight, as ActiveNeRF has it.

A pixel's colour is C = sum_i w_i c_i. Where the c_i are independent and have variances beta_i, C has the variance
V = sum_i w_i^2 beta_i (arXiv 2209.08546). On the CPU the variances are one more channel of the blending kernels, so
that V and its gradients come with the colours in one pass; on CUDA it is put together from gsplat's lists of blended
Gaussians, see ``variance_gsplat.py``.
"""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor

from avs.rasterizer.blended_view import Squares, blend_view, project_view
from avs.rasterizer.compositing import composite
from avs.rasterizer.constants import BLUR, FAR_PLANE, NEAR_PLANE
from avs.rasterizer.projection import project_gaussians
from avs.rasterizer.spherical_harmonics import view_dependent_colors
from avs.rasterizer.variance_kernels import sum_reductions

PLAIN, ATTENUATED = Squares(share=0.0, through=1.0), Squares(share=1.0, through=0.0)
"""The two ways to blend a variance, see ``rasterization_with_variance``."""


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
    """Render N Gaussians into C images with their variances; differentiable in all tensors but ``Ks``.

    Args:
        means: centres ``[N, 3]`` float32, as all other tensors.
        quats: rotations ``[N, 4]``, w first.
        scales: standard deviations ``[N, 3]``.
        opacities: ``[N]`` in 0..1.
        colors: spherical harmonics ``[N, K, 3]``.
        variances: ``[N]``.
        viewmats: world-to-camera matrices ``[C, 4, 4]``.
        Ks: intrinsics in pixels ``[C, 3, 3]``.
        width: image width in pixels.
        height: image height in pixels.
        sh_degree: highest degree of harmonics to use.
        absgrad: as in ``rasterizer.rasterization``; on CUDA without the part that comes through the variance.
        backgrounds: ``[C, 3]``; they are certain.
        attenuated: whether the squared weight is alpha_i T_{i+1} in the place of alpha_i T_i, T_i being the
            transmittance in front of Gaussian i; the gradient then goes to ``variances`` alone, with alpha_i T_i.

    Returns:
        Images ``[C, H, W, 3]``, variances ``[C, H, W]``, and ``meta`` as ``rasterizer.rasterization`` returns it.
    """
    if means.is_cuda:
        from avs.rasterizer import variance_gsplat

        return variance_gsplat.rasterization_with_variance(
            means, quats, scales, opacities, colors, variances, viewmats, Ks, width, height, sh_degree, absgrad,
            backgrounds, attenuated,
        )  # fmt: skip
    means, quats, scales, opacities, colors = (x.contiguous() for x in (means, quats, scales, opacities, colors))
    means2d, depths, conics, _, radii = project_gaussians(
        means, quats, scales, opacities, viewmats, Ks, width, height, NEAR_PLANE, FAR_PLANE, 0.0, BLUR, False
    )
    centres = torch.inverse(viewmats)[:, :3, 3].contiguous()
    shaded = view_dependent_colors(colors, means, centres, radii, sh_degree)
    columns = torch.cat([shaded, variances[None, :, None].expand(len(viewmats), -1, -1)], dim=-1)
    images, _ = composite(
        means2d, conics, opacities, columns, depths, radii, backgrounds, width, height, False, absgrad,
        squares=ATTENUATED if attenuated else PLAIN,
    )  # fmt: skip
    meta = {
        "gaussian_ids": None,
        "radii": radii,
        "means2d": means2d,
        "width": width,
        "height": height,
        "n_cameras": len(viewmats),
    }
    return images[..., :3], images[..., 3], meta


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
    """Return the variance that one camera's view removes, summed over its pixels, without gradients.

    With V = constant + sum_i w_i^2 beta_i, a Gaussian's variance becomes 1 / (1 / beta_i + w_i^2 / V) once the pixel
    has been seen. Two passes over the Gaussians of each pixel: the first renders V, the second adds up the reductions.

    Args:
        means: centres ``[N, 3]`` float32, as all other tensors.
        quats: rotations ``[N, 4]``, w first.
        scales: standard deviations ``[N, 3]``.
        opacities: ``[N]`` in 0..1.
        variances: beta ``[N]``.
        viewmat: world-to-camera matrix ``[4, 4]``.
        intrinsics: in pixels ``[3, 3]``.
        width: image width in pixels.
        height: image height in pixels.
        attenuated: as in ``rasterization_with_variance``.
        constant: added to the variance of each pixel.
        weighted: whether the variance of pixels is counted, V - sum_i w_i^2 / (1 / beta_i + w_i^2 / V), or that of the
            Gaussians in it, sum_i beta_i - sum_i 1 / (1 / beta_i + w_i^2 / V).
        saturated: whether nothing is left after the view in a pixel that stopped before its last Gaussian.
    """
    if means.is_cuda:
        from avs.rasterizer import variance_gsplat

        return variance_gsplat.variance_reduction(
            means, quats, scales, opacities, variances, viewmat, intrinsics, width, height, attenuated, constant,
            weighted, saturated,
        )  # fmt: skip
    how = ATTENUATED if attenuated else PLAIN
    view, _ = project_view(means, quats, scales, opacities, viewmat, intrinsics, width, height)
    blended = blend_view(view, variances.detach()[:, None].numpy(), width, height, squares=how)
    return float(
        sum_reductions(
            blended.records, blended.entries, blended.offsets, blended.transmittance, blended.pixels, how.share,
            constant, weighted, saturated, width, height,
        )
    )  # fmt: skip
