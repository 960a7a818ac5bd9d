"""The blending kernels as one differentiable operation on torch tensors."""

from __future__ import annotations

from typing import cast

import numpy as np
import torch
from torch import Tensor

from avs.rasterizer.blended_view import ProjectedView, Squares, blend_view
from avs.rasterizer.blending import to_image
from avs.rasterizer.blending_backward import CHANNELS, blend_backward, unpack_gradients
from avs.rasterizer.kernels import Context, Floats
from avs.rasterizer.tiles import TILE


class _Blend(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Context,
        means2d: Tensor,
        conics: Tensor,
        opacities: Tensor,
        colors: Tensor,
        depths: Tensor,
        backgrounds: Tensor | None,
        radii: Tensor,
        options: tuple[int, int, bool, bool, Squares | None],
    ) -> tuple[Tensor, Tensor]:
        width, height, with_depth, _, how = options
        cameras = len(means2d)
        images = torch.empty(cameras, height, width, colors.shape[-1] + with_depth)
        alphas = torch.empty(cameras, height, width, 1)
        kept = []
        for c in range(cameras):
            centre, conic, opacity, color, depth = _splats(c, means2d, conics, opacities, colors, depths)
            view = ProjectedView(centre, conic, opacity, depth, radii[c].numpy())
            blended = blend_view(view, color, width, height, with_depth, how)
            background = _background(backgrounds, c, blended.planes)
            to_image(
                blended.transmittance, blended.pixels, blended.planes, background, images[c].numpy(),
                alphas[c, :, :, 0].numpy(),
            )  # fmt: skip
            kept.append(blended)
        ctx.kept, ctx.options = kept, options
        ctx.save_for_backward(means2d, conics, opacities, colors, depths, backgrounds)
        return images, alphas

    @staticmethod
    def backward(ctx: Context, v_images: Tensor, v_alphas: Tensor) -> tuple[Tensor | None, ...]:
        means2d, conics, opacities, colors, depths, backgrounds = ctx.saved_tensors
        width, height, with_depth, absgrad, how = ctx.options
        through = how.through if how else 0.0
        v_means2d, v_conics = torch.zeros_like(means2d), torch.zeros_like(conics)
        v_absolute = torch.zeros_like(means2d) if absgrad else v_means2d
        v_opacities, v_colors = torch.zeros_like(opacities), torch.zeros_like(colors)
        v_depths = torch.zeros_like(depths)
        v_images, v_alphas = v_images.contiguous(), v_alphas.contiguous()
        for c in range(len(means2d)):
            view = ctx.kept[c]
            sums = blend_backward(
                view.records, view.entries, view.offsets, view.transmittance, view.pixels, view.channels, view.squares,
                through, (0,) * (CHANNELS + len(view.planes) + 2 * absgrad), _background(backgrounds, c, view.planes),
                v_images[c].numpy(), v_alphas[c, :, :, 0].numpy(),
            )  # fmt: skip
            _, conic, opacity, _, _ = _splats(c, means2d, conics, opacities, colors, depths)
            _, _, v_opacity, v_color, v_depth = _splats(c, means2d, conics, v_opacities, v_colors, v_depths)
            unpack_gradients(
                view.order, conic, opacity, sums, absgrad, with_depth,
                v_means2d[c].numpy(), v_absolute[c].numpy(), v_conics[c].numpy(), v_opacity, v_color, v_depth,
            )  # fmt: skip
        if absgrad:
            means2d.absgrad = v_absolute
        v_backgrounds = None
        if backgrounds is not None and ctx.needs_input_grad[5]:
            light = torch.stack([_light(view.transmittance, width, height) for view in ctx.kept])
            v_backgrounds = (v_images * light[..., None]).sum(dim=(1, 2))[:, : backgrounds.shape[-1]]
        return v_means2d, v_conics, v_opacities, v_colors, v_depths, v_backgrounds, None, None


def _splats(camera: int, *tensors: Tensor) -> tuple[Floats, ...]:
    """Return one camera's centres, conics, opacities, colours and depths as arrays; some are shared by all cameras."""
    own_dimensions = (2, 2, 1, 2, 1)
    pairs = zip(tensors, own_dimensions, strict=True)
    return tuple((x if x.ndim == own else x[camera]).detach().numpy() for x, own in pairs)


def _background(backgrounds: Tensor | None, camera: int, channels: tuple[int, ...]) -> Floats:
    """Return the background of each channel; depth, if there, has none."""
    values = np.zeros(len(channels), np.float32)
    if backgrounds is not None:
        row = backgrounds[camera].detach().numpy()
        values[: len(row)] = row
    return values


def _light(transmittance: Floats, width: int, height: int) -> Tensor:
    """Return the transmittance of one camera's pixels as an image ``[H, W]``."""
    columns = (width + TILE - 1) // TILE
    tiles = torch.from_numpy(transmittance).abs().reshape(-1, columns, TILE, TILE)
    return tiles.transpose(1, 2).reshape(-1, columns * TILE)[:height, :width]


def composite(
    means2d: Tensor,
    conics: Tensor,
    opacities: Tensor,
    colors: Tensor,
    depths: Tensor,
    radii: Tensor,
    backgrounds: Tensor | None,
    width: int,
    height: int,
    with_depth: bool,
    absgrad: bool,
    squares: Squares | None = None,
) -> tuple[Tensor, Tensor]:
    """Blend projected Gaussians from near to far into C images.

    Args:
        means2d: centres in pixels ``[C, N, 2]``. With ``absgrad``, the backward pass sets their attribute ``absgrad``.
        conics: inverse 2D covariances (xx, xy, yy) ``[C, N, 3]``.
        opacities: ``[C, N]``, or ``[N]`` for all cameras.
        colors: ``[C, N, D]``, or ``[N, D]`` for all cameras; D may be 0.
        depths: ``[C, N]``; they give the order and, on demand, a channel.
        radii: ``[C, N, 2]``; 0 for Gaussians out of sight.
        backgrounds: ``[C, D]`` or none; depth has no background.
        width: image width in pixels.
        height: image height in pixels.
        with_depth: whether depth is blended as the last channel.
        absgrad: whether the sums over pixels of the absolute gradients of the centres are taken (AbsGS).
        squares: how the last of the D columns is blended with squared weights, or None; not together with depth.

    Returns:
        Images ``[C, H, W, D + with_depth]`` and accumulated opacities ``[C, H, W, 1]``.
    """
    assert squares is None or not with_depth
    options = (width, height, with_depth, absgrad, squares)
    result = _Blend.apply(means2d, conics, opacities, colors, depths, backgrounds, radii, options)  # type: ignore[no-untyped-call]
    return cast("tuple[Tensor, Tensor]", result)
