"""One camera's Gaussians projected, ordered from near to far, packed and blended: what every pass begins with."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from avs.rasterizer.blending import blend
from avs.rasterizer.constants import BLUR, FAR_PLANE, NEAR_PLANE
from avs.rasterizer.kernels import Floats, Integers
from avs.rasterizer.projection import project_gaussians
from avs.rasterizer.splat_records import pack_records
from avs.rasterizer.tiles import depth_order


@dataclass(frozen=True)
class ProjectedView:
    """N Gaussians in the image of one camera. All but the opacities is 0 where one is out of sight.

    Attributes:
        means2d: centres in pixels ``[N, 2]``.
        conics: inverse 2D covariances (xx, xy, yy) ``[N, 3]``.
        opacities: as they are blended ``[N]``.
        depths: along the optical axis ``[N]``.
        radii: half the sides of their boxes in pixels ``[N, 2]`` int32.
    """

    means2d: Floats
    conics: Floats
    opacities: Floats
    depths: Floats
    radii: Integers


@dataclass(frozen=True)
class Squares:
    """How a channel is blended with squared weights.

    Attributes:
        share: the weight that is squared is alpha_i T_i (1 - share alpha_i), T_i being the transmittance in front.
        through: factor of the gradient that reaches the weights. The gradients are those of share 0.
    """

    share: float
    through: float


@dataclass(frozen=True)
class BlendedView:
    """M Gaussians that one camera sees, from near to far, and what blending them gave.

    Attributes:
        order: their indices ``[M]``.
        records: ``[M, width]``, see ``splat_records``.
        channels: a tuple as long as there are plain channels.
        squares: a tuple as long as there are channels of squared weights, which come after those.
        transmittance: of the pixels, as the three next ones see ``blending.blend``.
        pixels: blended channels.
        entries: tile lists.
        offsets: where each tile's list begins.
    """

    order: Integers
    records: Floats
    channels: tuple[int, ...]
    squares: tuple[int, ...]
    transmittance: Floats
    pixels: Floats
    entries: Integers
    offsets: Integers

    @property
    def planes(self) -> tuple[int, ...]:
        """A tuple as long as there are channels of both kinds."""
        return self.channels + self.squares


@torch.no_grad()
def project_view(
    means: Tensor,
    quats: Tensor,
    scales: Tensor,
    opacities: Tensor,
    viewmat: Tensor,
    intrinsics: Tensor,
    width: int,
    height: int,
    near_plane: float = NEAR_PLANE,
    far_plane: float = FAR_PLANE,
    eps2d: float = BLUR,
    antialiased: bool = False,
) -> tuple[ProjectedView, Floats]:
    """Project N Gaussians into one camera, without gradients.

    Args:
        means: centres ``[N, 3]`` float32, as all other tensors.
        quats: rotations ``[N, 4]``, w first.
        scales: standard deviations ``[N, 3]``.
        opacities: ``[N]`` in 0..1.
        viewmat: world-to-camera matrix ``[4, 4]``.
        intrinsics: in pixels ``[3, 3]``.
        width: image width in pixels.
        height: image height in pixels.
        near_plane: Gaussians nearer than this are left out.
        far_plane: Gaussians farther than this are left out.
        eps2d: variance in square pixels that is added to each image covariance.
        antialiased: whether opacities are multiplied by the compensations of Mip-Splatting (arXiv 2311.16493).

    Returns:
        The view, and the compensations ``[N]``.
    """
    projected = project_gaussians(
        means, quats, scales, opacities, viewmat[None], intrinsics[None], width, height,
        near_plane, far_plane, 0.0, eps2d, antialiased,
    )  # fmt: skip
    means2d, depths, conics, compensations, radii = (tensor[0].numpy() for tensor in projected)
    effective = opacities.detach().numpy()
    effective = effective * compensations if antialiased else effective
    return ProjectedView(means2d, conics, effective, depths, radii), compensations


def blend_view(
    view: ProjectedView,
    colors: Floats,
    width: int,
    height: int,
    with_depth: bool = False,
    squares: Squares | None = None,
) -> BlendedView:
    """Blend the Gaussians of one camera from near to far.

    Args:
        view: the Gaussians.
        colors: their channels ``[N, D]``; D may be 0.
        width: image width in pixels.
        height: image height in pixels.
        with_depth: whether depth is blended as the last channel.
        squares: how the last of the D channels is blended with squared weights, or None; not together with depth.
    """
    order = depth_order(view.depths, view.radii)
    records = pack_records(
        order, view.means2d, view.conics, view.opacities, colors, view.depths, view.radii, with_depth
    )
    squared = 0 if squares is None else 1
    channels, of_squares = (0,) * (colors.shape[1] + with_depth - squared), (0,) * squared
    blended = blend(records, channels, of_squares, squares.share if squares else 0.0, width, height)
    return BlendedView(order, records, channels, of_squares, *blended)
