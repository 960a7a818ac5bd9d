"""Rendered variance: each Gaussian's variance blended with the square of its weight, as ActiveNeRF has it.

A pixel's colour is C = sum_i w_i c_i. Where the c_i are independent and have variances beta_i, C has the variance
V = sum_i w_i^2 beta_i (arXiv 2209.08546). On the CPU the variances are one more channel of the blending kernels, so
that V and its gradients come with the colours in one pass; on CUDA it is put together from gsplat's lists of blended
Gaussians, see ``variance_gsplat.py``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from avs.rasterizer.blending import blend
from avs.rasterizer.compositing import Squares, composite
from avs.rasterizer.projection import project_gaussians
from avs.rasterizer.spherical_harmonics import view_dependent_colors
from avs.rasterizer.splat_records import pack_records
from avs.rasterizer.tiles import depth_order
from avs.rasterizer.variance_kernels import sum_reductions
from avs.representations.gaussians import variance_gsplat
from avs.representations.gaussians.parameters import Parameters
from avs.representations.learned_variance import VarianceReduction
from avs.scene.cameras import Cameras

NEAR, FAR, BLUR = 0.01, 1e10, 0.3
"""The defaults of ``rasterizer.rasterization``: nearest and farthest depth, variance added in square pixels."""

PLAIN, ATTENUATED = Squares(share=0.0, through=1.0), Squares(share=1.0, through=0.0)
"""The two ways to blend a variance, see ``avs.representations.learned_variance.VarianceLearning.attenuated``."""


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
        return variance_gsplat.rasterization_with_variance(
            means, quats, scales, opacities, colors, variances, viewmats, Ks, width, height, sh_degree, absgrad,
            backgrounds, attenuated,
        )  # fmt: skip
    means, quats, scales, opacities, colors = (x.contiguous() for x in (means, quats, scales, opacities, colors))
    means2d, depths, conics, _, radii = project_gaussians(
        means, quats, scales, opacities, viewmats, Ks, width, height, NEAR, FAR, 0.0, BLUR, False
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


@torch.no_grad()
def variance_reductions(
    parameters: Parameters, variances: Tensor, cameras: Cameras, attenuated: bool, rule: VarianceReduction
) -> npt.NDArray[np.float64]:
    """Return, for each of n cameras, the variance that its view removes, summed over pixels: ``[n]``.

    Two passes over the Gaussians of each pixel: the first renders the variance, the second adds up the reductions.

    Args:
        parameters: of N Gaussians, before activation.
        variances: ``[N]`` float32.
        cameras: of any sizes.
        attenuated: as in ``rasterization_with_variance``.
        rule: what is counted.
    """
    compute = variance_gsplat.variance_reduction if variances.is_cuda else _variance_reduction
    gaussians = {
        "means": parameters["means"].detach(),
        "quats": parameters["quats"].detach(),
        "scales": parameters["scales"].exp(),
        "opacities": parameters["opacities"].sigmoid(),
        "variances": variances,
    }
    matrices = torch.tensor(cameras.world_to_camera, dtype=torch.float32, device=variances.device)
    intrinsics = torch.tensor(cameras.intrinsics, dtype=torch.float32, device=variances.device)
    reductions = [
        compute(gaussians, matrices[c : c + 1], intrinsics[c : c + 1], int(width), int(height), attenuated, rule)
        for c, (width, height) in enumerate(cameras.sizes)
    ]
    return np.array(reductions, dtype=np.float64)


def _variance_reduction(
    gaussians: dict[str, Tensor],
    viewmats: Tensor,
    intrinsics: Tensor,
    width: int,
    height: int,
    attenuated: bool,
    rule: VarianceReduction,
) -> float:
    """Return the sum for one camera; ``gaussians`` are after activation."""
    means, quats, scales, opacities = (gaussians[name] for name in ("means", "quats", "scales", "opacities"))
    means2d, depths, conics, _, radii = project_gaussians(
        means, quats, scales, opacities, viewmats, intrinsics, width, height, NEAR, FAR, 0.0, BLUR, False
    )
    image, depth, conic, radius = (x[0].numpy() for x in (means2d, depths, conics, radii))
    order = depth_order(depth, radius)
    column = gaussians["variances"][:, None].numpy()
    records = pack_records(order, image, conic, opacities.numpy(), column, depth, radius, False)
    share = (ATTENUATED if attenuated else PLAIN).share
    transmittance, rendered, entries, offsets = blend(records, (), (0,), share, width, height)
    return float(
        sum_reductions(
            records, entries, offsets, transmittance, rendered, share, rule.constant, rule.weighted, rule.saturated,
            width, height,
        )
    )  # fmt: skip
