"""Diagonal Fisher information of one rendering, as FisherRF uses it to choose views (arXiv 2311.17874)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from torch import Tensor

from avs.rasterizer.blended_view import blend_view, project_view
from avs.rasterizer.constants import BLUR, FAR_PLANE, NEAR_PLANE
from avs.rasterizer.fisher_chain import apply_chain
from avs.rasterizer.fisher_moments import WEIGHT, second_moments
from avs.rasterizer.kernels import Floats, Integers
from avs.rasterizer.projection import camera_numbers
from avs.rasterizer.spherical_harmonics import view_dependent_colors


@dataclass(frozen=True)
class FisherDiagonal:
    """Per parameter, the sum over pixels of the squared derivative of the pixel's channel sum; float32, not negative.

    It is 0 for Gaussians without a row and for harmonics above the degree that was rendered.

    Attributes:
        rows: the M Gaussians that show in the image, ``[M]`` int64, ascending.
        means: ``[M, 3]``.
        scales: ``[M, 3]``.
        quats: ``[M, 4]``, or ``[0, 4]`` where they were left out.
        opacities: ``[M]``.
        sh: ``[M, (d + 1)^2, 3]``, d being the degree that was rendered.
    """

    rows: Tensor
    means: Tensor
    scales: Tensor
    quats: Tensor
    opacities: Tensor
    sh: Tensor


@torch.no_grad()
def fisher_diagonal(
    means: Tensor,
    quats: Tensor,
    scales: Tensor,
    opacities: Tensor,
    sh_coefficients: Tensor,
    viewmat: Tensor,
    intrinsics: Tensor,
    width: int,
    height: int,
    sh_degree: int,
    background: Tensor | None = None,
    near_plane: float = NEAR_PLANE,
    far_plane: float = FAR_PLANE,
    eps2d: float = BLUR,
    rasterize_mode: Literal["classic", "antialiased"] = "classic",
    rotations: bool = True,
) -> FisherDiagonal:
    """Return the diagonal of J^T J of one rendering, J being the derivative of each pixel's channel sum.

    Exact: no probes, no sampling. The parameters are the tensors as passed (scales after the exponential, opacities
    after the sigmoid); the chain through the activations is the caller's.

    It differs from FisherRF's CUDA kernel in these points:

    * The opacity is held at 0.999, not 0.99, as in :func:`~avs.rasterizer.rasterization.rasterization`.
    * Quaternions are normalised inside, so that their derivative has no radial part; FisherRF's kernel is handed
      normalised ones and differentiates as if they were free. FisherRF's score leaves rotations out by default.
    * FisherRF's kernel offsets the pointer to the harmonics by K floats per Gaussian instead of 3 K, so that above
      degree 0 its derivative of the colour by the centre uses other Gaussians' coefficients. Here they are a
      Gaussian's own.
    * No derivative flows through a channel held at 0, nor through an opacity held at 0.999.

    Args:
        means: centres ``[N, 3]`` float32, as all other tensors.
        quats: rotations ``[N, 4]``, w first.
        scales: standard deviations ``[N, 3]``.
        opacities: ``[N]`` in 0..1.
        sh_coefficients: spherical harmonics ``[N, K, 3]``.
        viewmat: world-to-camera matrix ``[4, 4]``.
        intrinsics: in pixels ``[3, 3]``.
        width: image width in pixels.
        height: image height in pixels.
        sh_degree: highest degree of harmonics to use.
        background: ``[3]``; black by default.
        near_plane: Gaussians nearer than this are left out.
        far_plane: Gaussians farther than this are left out.
        eps2d: variance in square pixels that is added to each image covariance.
        rasterize_mode: as in ``rasterization``.
        rotations: whether the diagonal by the quaternions is wanted.
    """
    antialiased = rasterize_mode == "antialiased"
    means, quats, scales = means.contiguous(), quats.contiguous(), scales.contiguous()
    opacities, sh_coefficients = opacities.contiguous(), sh_coefficients.contiguous()
    view, compensations = project_view(
        means, quats, scales, opacities, viewmat, intrinsics, width, height, near_plane, far_plane, eps2d, antialiased
    )
    centre = torch.inverse(viewmat)[:3, 3].contiguous()
    radii = torch.from_numpy(view.radii)[None]
    colors = view_dependent_colors(sh_coefficients, means, centre[None], radii, sh_degree)[0]
    blended = blend_view(view, colors.sum(dim=1, keepdim=True).numpy(), width, height)
    behind = np.float32(0.0 if background is None else float(background.sum()))
    shears = view.conics[blended.order, 1] / view.conics[blended.order, 2]
    moments = second_moments(
        blended.records, shears, blended.entries, blended.offsets, blended.transmittance, blended.pixels, behind,
        width, height,
    )  # fmt: skip
    gaussians, places = _shown(blended.order, moments)
    count = len(gaussians)
    result = FisherDiagonal(
        rows=torch.from_numpy(gaussians),
        means=torch.empty(count, 3),
        scales=torch.empty(count, 3),
        quats=torch.empty(count if rotations else 0, 4),
        opacities=torch.empty(count),
        sh=torch.zeros(count, (sh_degree + 1) ** 2, 3),
    )
    pose, lens = camera_numbers(viewmat, intrinsics, width, height)
    apply_chain(
        gaussians, places, moments, shears, *(x.numpy() for x in (means, quats, scales, opacities, sh_coefficients)),
        colors.numpy(), view.conics, compensations, pose, lens, centre.numpy(), np.float32(eps2d), sh_degree,
        antialiased, result.means.numpy(), result.quats.numpy(), result.scales.numpy(), result.opacities.numpy(),
        result.sh.numpy(),
    )  # fmt: skip
    return result


def _shown(order: Integers, moments: Floats) -> tuple[Integers, Integers]:
    """Return the Gaussians that are blended somewhere, ascending, and the places of their moments."""
    places = np.flatnonzero(moments[:, WEIGHT] > 0)
    places = places[np.argsort(order[places])]
    return order[places].astype(np.int64), places
