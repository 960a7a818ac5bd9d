"""Rendering, loss and gradients of an optimisation step on the CPU, in one differentiable operation.

The kernels are those of ``rasterization`` and ``photometric_loss``, called in the same order on the same numbers, so
that value and gradients have the same bits. A graph of four operations becomes one: of a step of 6,000 Gaussians at 176
pixels the bookkeeping of the others takes a sixteenth (``python -m tests.benchmarks.bench_step``).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import torch
from torch import Tensor

from avs.rasterizer.blended_view import BlendedView, ProjectedView, blend_view, project_view
from avs.rasterizer.blending import to_image
from avs.rasterizer.blending_backward import CHANNELS, blend_backward, unpack_gradients
from avs.rasterizer.constants import BLUR
from avs.rasterizer.dssim import l1_dssim
from avs.rasterizer.kernels import Context, Floats
from avs.rasterizer.losses import Target
from avs.rasterizer.projection import camera_numbers, project_backward_kernel
from avs.rasterizer.spherical_harmonics import color_backward_kernel, color_kernel


@dataclass(frozen=True)
class _Gaussians:
    """The differentiable tensors as arrays: ``[N, 3]``, ``[N, 4]``, ``[N, 3]``, ``[N]``, ``[N, K, 3]``."""

    means: Floats
    quats: Floats
    scales: Floats
    opacities: Floats
    coefficients: Floats


@dataclass(frozen=True)
class _Shot:
    """What is rendered and compared: a camera, and its photograph."""

    viewmat: Tensor
    intrinsics: Tensor
    width: int
    height: int
    degree: int
    background: Floats
    target: Target
    ssim_weight: float
    absgrad: bool

    @property
    def numbers(self) -> tuple[Any, Any]:
        return camera_numbers(self.viewmat, self.intrinsics, self.width, self.height)

    @property
    def centre(self) -> Floats:
        return np.array(_centre(self.viewmat.numpy().tobytes()), np.float32)


@dataclass(frozen=True)
class _Seen:
    """The Gaussians in the image."""

    view: ProjectedView
    compensations: Floats
    colors: Floats
    blended: BlendedView


def photometric_step(
    means: Tensor,
    quats: Tensor,
    scales: Tensor,
    opacities: Tensor,
    colors: Tensor,
    viewmats: Tensor,
    Ks: Tensor,
    width: int,
    height: int,
    sh_degree: int,
    absgrad: bool,
    backgrounds: Tensor,
    target: Target,
    ssim_weight: float,
) -> tuple[Tensor, dict[str, Any]]:
    """Return ``photometric_loss`` of ``rasterization``, differentiable in the Gaussians.

    Args:
        means: of this and what follows up to ``backgrounds``, see ``rasterization``; one camera, without a gradient.
        quats: rotations.
        scales: standard deviations.
        opacities: in 0..1.
        colors: spherical harmonics.
        viewmats: ``[1, 4, 4]``.
        Ks: ``[1, 3, 3]``.
        width: image width in pixels.
        height: image height in pixels.
        sh_degree: highest degree of harmonics to use.
        absgrad: whether absolute gradients of the image positions are kept, too.
        backgrounds: ``[1, 3]``.
        target: the photograph.
        ssim_weight: see ``photometric_loss``.

    Returns:
        The loss, a scalar, which can be differentiated once, and what gsplat's densification strategies read:
        ``means2d`` ``[1, N, 2]``, which has its gradient at once, that of the loss itself, ``radii`` ``[1, N, 2]``,
        ``width``, ``height``, ``n_cameras``, ``gaussian_ids`` (None).
    """
    background = backgrounds[0].numpy()
    shot = _Shot(viewmats[0], Ks[0], width, height, sh_degree, background, target, ssim_weight, absgrad)
    meta: dict[str, Any] = {"gaussian_ids": None, "width": width, "height": height, "n_cameras": 1}
    loss = _Step.apply(means, quats, scales, opacities, colors, shot, meta)  # type: ignore[no-untyped-call]
    return cast(Tensor, loss), meta


class _Step(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Context,
        means: Tensor,
        quats: Tensor,
        scales: Tensor,
        opacities: Tensor,
        colors: Tensor,
        shot: _Shot,
        meta: dict[str, Any],
    ) -> Tensor:
        tensors = (means, quats, scales, opacities, colors)
        gaussians = _Gaussians(*(x.detach().contiguous().numpy() for x in tensors))
        seen = _seen(gaussians, shot)
        value, v_image = _loss(seen.blended, shot)
        gradients, v_means2d, v_absolute = _gradients(gaussians, shot, seen, v_image)
        ctx.gradients = tuple(map(torch.from_numpy, gradients))
        meta["radii"] = torch.from_numpy(seen.view.radii)[None]
        meta["means2d"] = torch.from_numpy(seen.view.means2d)[None].requires_grad_()
        meta["means2d"].grad = torch.from_numpy(v_means2d)[None]
        if shot.absgrad:
            meta["means2d"].absgrad = torch.from_numpy(v_absolute)[None]
        return means.new_tensor(value)

    @staticmethod
    def backward(ctx: Context, v_loss: Tensor) -> tuple[Tensor | None, ...]:
        # Given up here, so that a parameter takes its gradient over instead of a copy.
        gradients, ctx.gradients = ctx.gradients, None
        if gradients is None:
            raise RuntimeError("a photometric step is differentiated once")
        factor = float(v_loss)
        return *(x if factor == 1.0 else x * factor for x in gradients), None, None


def _seen(gaussians: _Gaussians, shot: _Shot) -> _Seen:
    """Project the Gaussians, colour them, and blend them."""
    shapes = (gaussians.means, gaussians.quats, gaussians.scales, gaussians.opacities)
    means, quats, scales, opacities = map(torch.from_numpy, shapes)
    view, compensations = project_view(
        means, quats, scales, opacities, shot.viewmat, shot.intrinsics, shot.width, shot.height
    )
    colors = np.empty_like(gaussians.means)
    color_kernel(shot.degree, gaussians.means, shot.centre, gaussians.coefficients, view.radii, colors)
    return _Seen(view, compensations, colors, blend_view(view, colors, shot.width, shot.height))


def _loss(blended: BlendedView, shot: _Shot) -> tuple[float, Floats]:
    """Return the loss and its gradient with respect to the image ``[height, width, 3]``."""
    image = np.empty((shot.height, shot.width, 3), np.float32)
    alpha = np.empty((shot.height, shot.width), np.float32)
    to_image(blended.transmittance, blended.pixels, blended.planes, shot.background, image, alpha)
    assert shot.target.moments is not None
    return l1_dssim(image, shot.target.image.numpy(), shot.target.moments, shot.ssim_weight)


def _gradients(
    gaussians: _Gaussians, shot: _Shot, seen: _Seen, v_image: Floats
) -> tuple[tuple[Floats, ...], Floats, Floats]:
    """Return the gradients of the Gaussians, in their order, of the image positions, and the absolute ones of these."""
    view, blended = seen.view, seen.blended
    sums = blend_backward(
        blended.records, blended.entries, blended.offsets, blended.transmittance, blended.pixels, blended.channels,
        blended.squares, 0.0, (0,) * (CHANNELS + len(blended.planes) + 2 * shot.absgrad), shot.background,
        v_image, np.zeros((shot.height, shot.width), np.float32),
    )  # fmt: skip
    v_means2d, v_conics, v_depths = (np.zeros_like(x) for x in (view.means2d, view.conics, view.depths))
    v_absolute = np.zeros_like(v_means2d) if shot.absgrad else v_means2d
    v_opacities, v_colors = np.zeros_like(view.opacities), np.zeros_like(seen.colors)
    unpack_gradients(
        blended.order, view.conics, view.opacities, sums, shot.absgrad, False, v_means2d, v_absolute, v_conics,
        v_opacities, v_colors, v_depths,
    )  # fmt: skip
    means, quats, scales = gaussians.means, gaussians.quats, gaussians.scales
    v_means, v_quats, v_scales = np.zeros_like(means), np.zeros_like(quats), np.zeros_like(scales)
    v_coefficients = np.zeros_like(gaussians.coefficients)
    color_backward_kernel(
        shot.degree, means, shot.centre, gaussians.coefficients, seen.colors, v_colors, v_means,
        np.zeros(3, np.float32), v_coefficients,
    )  # fmt: skip
    pose, lens = shot.numbers
    project_backward_kernel(
        means, quats, scales, pose, lens, np.float32(BLUR), view.radii, view.conics, seen.compensations, v_means2d,
        v_depths, v_conics, np.zeros_like(v_depths), False, v_means, v_quats, v_scales, np.zeros((4, 4), np.float32),
    )  # fmt: skip
    return (v_means, v_quats, v_scales, v_opacities, v_coefficients), v_means2d, v_absolute


@functools.lru_cache(maxsize=4096)
def _centre(viewmat: bytes) -> tuple[np.float32, ...]:
    """Return the centre of a camera, as ``rasterization`` computes it."""
    matrix = torch.from_numpy(np.frombuffer(viewmat, np.float32).copy()).reshape(1, 4, 4)
    return tuple(torch.inverse(matrix)[0, :3, 3].numpy())
