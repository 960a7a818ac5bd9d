"""A slow, obvious Gaussian renderer: every pixel against every Gaussian, float64, gradients by autograd.

The twin that the fast rasteriser is tested against. It has no tiles, no extents and no loops over pixels, and shares no
code with what it tests.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

ALPHA_MAX = 0.999
ALPHA_MIN = 1.0 / 255.0
TRANSMITTANCE_MIN = 1e-4


def rotation_matrices(quats: Tensor) -> Tensor:
    """Return ``[N, 3, 3]`` from quaternions ``[N, 4]``, w first, of any length."""
    w, x, y, z = (quats / quats.norm(dim=-1, keepdim=True)).unbind(-1)
    rows = [
        torch.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
        torch.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
        torch.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1),
    ]
    return torch.stack(rows, -2)


def associated_legendre(degree: int, order: int, z: Tensor) -> Tensor:
    """Return P_degree^order(z) / (1 - z^2)^(order / 2) without the Condon-Shortley sign, by the standard recurrence."""
    diagonal = torch.ones_like(z)
    for m in range(1, order + 1):
        diagonal = diagonal * (2 * m - 1)
    if degree == order:
        return diagonal
    below, current = diagonal, z * (2 * order + 1) * diagonal
    for n in range(order + 2, degree + 1):
        below, current = current, ((2 * n - 1) * z * current - (n + order - 1) * below) / (n - order)
    return current


def harmonics(degree: int, directions: Tensor) -> Tensor:
    """Return the real spherical harmonics ``[N, (degree + 1)^2]``, order m from -l to l, sign (-1)^m."""
    x, y, z = (directions / directions.norm(dim=-1, keepdim=True)).unbind(-1)
    columns = []
    for n in range(degree + 1):
        for m in range(-n, n + 1):
            k = abs(m)
            norm = math.sqrt((2 * n + 1) / (4 * math.pi) * math.factorial(n - k) / math.factorial(n + k))
            # (x + i y)^k by multiplication, which stays differentiable on the axis
            real, imaginary = torch.ones_like(x), torch.zeros_like(x)
            for _ in range(k):
                real, imaginary = real * x - imaginary * y, real * y + imaginary * x
            turn = torch.ones_like(x) if m == 0 else math.sqrt(2) * (real if m > 0 else imaginary)
            columns.append((-1) ** k * norm * turn * associated_legendre(n, k, z))
    return torch.stack(columns, -1)


def project(means, quats, scales, viewmat, intrinsics, width, height, eps2d):
    """Return centres ``[N, 2]``, covariances ``[N, 2, 2]`` before and after the blur, and depths ``[N]``."""
    rotation, translation = viewmat[:3, :3], viewmat[:3, 3]
    points = means @ rotation.T + translation
    x, y, z = points.unbind(-1)
    fx, fy, cx, cy = intrinsics[0, 0], intrinsics[1, 1], intrinsics[0, 2], intrinsics[1, 2]
    held_x = (x / z).clamp(-(cx + 0.15 * width) / fx, (width - cx + 0.15 * width) / fx) * z
    held_y = (y / z).clamp(-(cy + 0.15 * height) / fy, (height - cy + 0.15 * height) / fy) * z
    zero = torch.zeros_like(z)
    jacobian = torch.stack(
        [
            torch.stack([fx / z, zero, -fx * held_x / z**2], -1),
            torch.stack([zero, fy / z, -fy * held_y / z**2], -1),
        ],
        -2,
    )
    factor = rotation_matrices(quats) * scales[:, None, :]
    covariance = factor @ factor.transpose(1, 2)
    sharp = jacobian @ rotation @ covariance @ rotation.T @ jacobian.transpose(1, 2)
    blurred = sharp + eps2d * torch.eye(2, dtype=means.dtype)
    return torch.stack([fx * x / z + cx, fy * y / z + cy], -1), sharp, blurred, z


def render(
    means,
    quats,
    scales,
    opacities,
    colors,
    viewmat,
    intrinsics,
    width,
    height,
    near_plane=0.01,
    far_plane=1e10,
    eps2d=0.3,
    sh_degree=None,
    background=None,
    render_mode="RGB",
    rasterize_mode="classic",
):
    """Render one camera; arguments as those of ``gsplat.rasterization`` without the axis of cameras."""
    centres, sharp, blurred, depths = project(means, quats, scales, viewmat, intrinsics, width, height, eps2d)
    if rasterize_mode == "antialiased":
        opacities = opacities * (torch.linalg.det(sharp).clamp(min=0) / torch.linalg.det(blurred)).sqrt()
    if sh_degree is not None:
        directions = means - torch.inverse(viewmat)[:3, 3]
        terms = (sh_degree + 1) ** 2
        colors = torch.einsum("nk,nkc->nc", harmonics(sh_degree, directions), colors[:, :terms]) + 0.5
        colors = colors.clamp(min=0)
    if render_mode in ("D", "ED"):
        colors, background = depths[:, None], None
    elif render_mode != "RGB":
        colors = torch.cat([colors, depths[:, None]], -1)
        background = None if background is None else torch.cat([background, background.new_zeros(1)])

    seen = torch.nonzero((depths >= near_plane) & (depths <= far_plane))[:, 0]
    seen = seen[torch.argsort(depths[seen].detach().float(), stable=True)]
    inverse = torch.linalg.inv(blurred[seen])
    rows, columns = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    pixels = torch.stack([columns, rows], -1).reshape(-1, 1, 2).to(means.dtype) + 0.5
    offsets = pixels - centres[seen]
    power = -0.5 * torch.einsum("pni,nij,pnj->pn", offsets, inverse, offsets)
    alphas = (opacities[seen] * power.exp()).clamp(max=ALPHA_MAX)
    alphas = torch.where(alphas >= ALPHA_MIN, alphas, 0)
    after = torch.cumprod(1 - alphas, dim=1)
    alive = after > TRANSMITTANCE_MIN  # cumprod falls, so once false it stays false
    alphas = torch.where(alive, alphas, 0)
    after = torch.cumprod(1 - alphas, dim=1)
    before = torch.cat([torch.ones_like(after[:, :1]), after[:, :-1]], 1)
    light = after[:, -1:] if len(seen) else torch.ones(len(pixels), 1, dtype=means.dtype)
    image = (alphas * before) @ colors[seen]
    if background is not None:
        image = image + light * background
    if render_mode.endswith("ED"):
        image = torch.cat([image[:, :-1], image[:, -1:] / (1 - light).clamp(min=1e-10)], -1)
    return image.reshape(height, width, -1), (1 - light).reshape(height, width, 1)
