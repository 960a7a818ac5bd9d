"""Rasterisation of 3D Gaussians on the CPU: a drop-in for ``gsplat.rasterization`` 1.5.3, which needs CUDA."""

from __future__ import annotations

from typing import Any, Literal, get_args

import torch
from torch import Tensor

from avs.rasterizer.compositing import composite
from avs.rasterizer.constants import BLUR, FAR_PLANE, NEAR_PLANE
from avs.rasterizer.projection import project_gaussians
from avs.rasterizer.spherical_harmonics import MAX_DEGREE, view_dependent_colors

RenderMode = Literal["RGB", "D", "ED", "RGB+D", "RGB+ED"]
RasterizeMode = Literal["classic", "antialiased"]
# gsplat's guard against dividing by an accumulated opacity of 0.
_ALPHA_GUARD = 1e-10


# Long by gsplat's signature, and by what must be told of it.
def rasterization(
    means: Tensor,
    quats: Tensor,
    scales: Tensor,
    opacities: Tensor,
    colors: Tensor,
    viewmats: Tensor,
    Ks: Tensor,
    width: int,
    height: int,
    near_plane: float = NEAR_PLANE,
    far_plane: float = FAR_PLANE,
    radius_clip: float = 0.0,
    eps2d: float = BLUR,
    sh_degree: int | None = None,
    packed: bool = True,
    tile_size: int = 16,
    backgrounds: Tensor | None = None,
    render_mode: RenderMode = "RGB",
    sparse_grad: bool = False,
    absgrad: bool = False,
    rasterize_mode: RasterizeMode = "classic",
    channel_chunk: int = 32,
    distributed: bool = False,
    camera_model: Literal["pinhole", "ortho", "fisheye", "ftheta"] = "pinhole",
    segmented: bool = False,
    covars: Tensor | None = None,
    with_ut: bool = False,
    with_eval3d: bool = False,
    radial_coeffs: Tensor | None = None,
    tangential_coeffs: Tensor | None = None,
    thin_prism_coeffs: Tensor | None = None,
    ftheta_coeffs: object = None,
    rolling_shutter: object = None,
    viewmats_rs: Tensor | None = None,
) -> tuple[Tensor, Tensor, dict[str, Any]]:
    """Render N Gaussians into C images; differentiable in all tensors but ``Ks``.

    On CUDA tensors the call is handed to ``gsplat.rasterization`` as it is. On the CPU it is computed here, on one
    thread and to the same bits each time, by the same formulas: pixel centres at .5; opacities below 1/255 ignored and
    held at 0.999; a pixel stops before the Gaussian that would bring its transmittance to 1e-4 or below; colours
    ``max(harmonics + 0.5, 0)``; the projection's Jacobian held 0.3 half fields of view outside the image.

    Where the CPU differs from gsplat 1.5.3:

    * The extent of a Gaussian is its ellipse at opacity 1/255, per row of 8x8 tiles, not a box cut off at 3.33 standard
      deviations (3DGS: a square at 3). As only opacities of 1/255 and above are blended, pixels are the same as
      gsplat's for opacities up to 1; only ``radii`` is a bound of the same kind.
    * ``packed``, ``tile_size``, ``channel_chunk`` and ``segmented`` choose between ways of computing the same on a
      GPU and are without effect: ``meta`` always has the unpacked layout (call gsplat's strategies with
      ``packed=False``), and lacks the tile lists.
    * Leading batch dimensions, ``distributed``, ``sparse_grad``, ``covars``, cameras other than ``pinhole``,
      distortion, rolling shutter, ``with_ut`` and ``with_eval3d`` are not there.

    Args:
        means: centres ``[N, 3]`` float32, as all other tensors.
        quats: rotations ``[N, 4]``, w first, of any length but 0.
        scales: standard deviations ``[N, 3]``.
        opacities: ``[N]`` in 0..1.
        colors: ``[N, D]`` or ``[C, N, D]``; with ``sh_degree``, spherical harmonics ``[N, K, 3]`` or ``[C, N, K, 3]``.
        viewmats: world-to-camera matrices ``[C, 4, 4]``, OpenCV axes.
        Ks: intrinsics in pixels ``[C, 3, 3]``, without skew.
        width: image width in pixels.
        height: image height in pixels.
        near_plane: Gaussians nearer than this are left out.
        far_plane: Gaussians farther than this are left out.
        radius_clip: Gaussians that extend no farther than this many pixels are left out.
        eps2d: variance in square pixels that is added to each image covariance.
        sh_degree: highest degree of harmonics to use, 0 to 4; none for plain colours.
        packed: without effect.
        tile_size: without effect.
        backgrounds: ``[C, D]``; black by default. Depth has no background.
        render_mode: colours, blended depth (``D``), expected depth (``ED``: divided by the accumulated opacity), or
            both.
        sparse_grad: not supported.
        absgrad: set ``meta["means2d"].absgrad`` in the backward pass (AbsGS, arXiv 2404.10484).
        rasterize_mode: ``antialiased`` multiplies opacities by the compensation of Mip-Splatting (arXiv 2311.16493).
        channel_chunk: without effect.
        distributed: not supported.
        camera_model: ``pinhole``.
        segmented: without effect.
        covars: not supported.
        with_ut: not supported.
        with_eval3d: not supported.
        radial_coeffs: not supported.
        tangential_coeffs: not supported.
        thin_prism_coeffs: not supported.
        ftheta_coeffs: not supported.
        rolling_shutter: not supported.
        viewmats_rs: not supported.

    Returns:
        Images ``[C, H, W, X]`` with X = D, 1 or D + 1 by ``render_mode``; accumulated opacities ``[C, H, W, 1]``; and
        what gsplat's densification strategies read: ``means2d`` ``[C, N, 2]`` (in the graph), ``radii`` ``[C, N, 2]``,
        ``depths``, ``conics``, ``opacities`` ``[C, N]``, ``width``, ``height``, ``n_cameras``, ``gaussian_ids`` (None).

    Raises:
        ValueError: an argument has a wrong shape, type or value.
        NotImplementedError: an option of gsplat that is not supported on the CPU.
    """
    arguments = dict(locals())
    if means.is_cuda:
        return _on_gpu(arguments)
    _check_options(arguments)
    _check_tensors(means, quats, scales, opacities, colors, viewmats, Ks, backgrounds, sh_degree, render_mode)
    antialiased = rasterize_mode == "antialiased"
    means, quats, scales, opacities, colors = (x.contiguous() for x in (means, quats, scales, opacities, colors))
    means2d, depths, conics, compensations, radii = project_gaussians(
        means, quats, scales, opacities, viewmats, Ks, width, height,
        near_plane, far_plane, radius_clip, eps2d, antialiased,
    )  # fmt: skip
    effective = opacities * compensations if antialiased else opacities
    if not render_mode.startswith("RGB"):
        colors, backgrounds = colors.new_empty(len(means), 0), None
    elif sh_degree is not None:
        centres = torch.inverse(viewmats)[:, :3, 3].contiguous()
        colors = view_dependent_colors(colors, means, centres, radii, sh_degree)
    images, alphas = composite(
        means2d,
        conics,
        effective,
        colors,
        depths,
        radii,
        backgrounds,
        width,
        height,
        render_mode.endswith("D"),
        absgrad,
    )
    if render_mode.endswith("ED"):
        images = torch.cat([images[..., :-1], images[..., -1:] / alphas.clamp(min=_ALPHA_GUARD)], dim=-1)
    meta = {
        "batch_ids": None,
        "camera_ids": None,
        "gaussian_ids": None,
        "radii": radii,
        "means2d": means2d,
        "depths": depths,
        "conics": conics,
        "opacities": effective.expand(len(viewmats), len(means)),
        "width": width,
        "height": height,
        "n_batches": 1,
        "n_cameras": len(viewmats),
    }
    return images, alphas, meta


def _on_gpu(arguments: dict[str, Any]) -> tuple[Tensor, Tensor, dict[str, Any]]:
    """Hand the call to gsplat."""
    import gsplat

    if arguments["rolling_shutter"] is None:
        del arguments["rolling_shutter"]
    images, alphas, meta = gsplat.rasterization(**arguments)
    return images, alphas, meta


def _check_options(arguments: dict[str, Any]) -> None:
    """Refuse what only gsplat has, and modes that nobody has."""
    only_default = {"distributed": False, "sparse_grad": False, "camera_model": "pinhole", "covars": None}
    only_default |= {"with_ut": False, "with_eval3d": False, "radial_coeffs": None, "tangential_coeffs": None}
    only_default |= {"thin_prism_coeffs": None, "ftheta_coeffs": None, "rolling_shutter": None, "viewmats_rs": None}
    for name, default in only_default.items():
        value = arguments[name]
        if value is not default and not (isinstance(value, str) and value == default):
            if name == "rolling_shutter" and getattr(value, "name", None) == "GLOBAL":
                continue
            raise NotImplementedError(f"{name}: not supported on the CPU, leave it at {default!r} or use CUDA tensors")
    for name, values in (("render_mode", get_args(RenderMode)), ("rasterize_mode", get_args(RasterizeMode))):
        if arguments[name] not in values:
            raise ValueError(f"{name}: {arguments[name]!r} is none of {', '.join(values)}")
    if arguments["width"] < 1 or arguments["height"] < 1:
        raise ValueError(f"width, height: an image of {arguments['width']} x {arguments['height']} pixels is empty")


def _check_tensors(
    means: Tensor,
    quats: Tensor,
    scales: Tensor,
    opacities: Tensor,
    colors: Tensor,
    viewmats: Tensor,
    intrinsics: Tensor,
    backgrounds: Tensor | None,
    sh_degree: int | None,
    render_mode: str,
) -> None:
    """Check shapes and types, naming the argument at fault."""
    if means.ndim != 2:
        raise NotImplementedError(
            f"means: shape {tuple(means.shape)}, but batch dimensions are not supported on the CPU"
        )
    count, cameras = len(means), len(viewmats)
    channels = colors.shape[-1:]
    if sh_degree is not None:
        if not 0 <= sh_degree <= MAX_DEGREE:
            raise ValueError(f"sh_degree: {sh_degree} is not within 0..{MAX_DEGREE}")
        if colors.ndim < 3 or colors.shape[-2] < (sh_degree + 1) ** 2:
            raise ValueError(f"colors: shape {tuple(colors.shape)} lacks the harmonics of degree {sh_degree}")
        channels = torch.Size((colors.shape[-2], 3))
    expected: dict[str, tuple[Tensor, list[tuple[int, ...]]]] = {
        "means": (means, [(count, 3)]),
        "quats": (quats, [(count, 4)]),
        "scales": (scales, [(count, 3)]),
        "opacities": (opacities, [(count,)]),
        "colors": (colors, [(count, *channels), (cameras, count, *channels)]),
        "viewmats": (viewmats, [(cameras, 4, 4)]),
        "Ks": (intrinsics, [(cameras, 3, 3)]),
    }
    if backgrounds is not None and render_mode.startswith("RGB"):
        expected["backgrounds"] = (backgrounds, [(cameras, channels[-1])])
    for name, (tensor, shapes) in expected.items():
        if tuple(tensor.shape) not in shapes:
            raise ValueError(f"{name}: shape {tuple(tensor.shape)} instead of {' or '.join(map(str, shapes))}")
        if tensor.dtype != torch.float32 or tensor.is_cuda:
            raise ValueError(f"{name}: {tensor.dtype} on {tensor.device} instead of torch.float32 on cpu")
