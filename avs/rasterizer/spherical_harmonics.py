"""Colours from spherical harmonics (real, with the Condon-Shortley sign), degrees 0 to 4, and their derivatives.

The order of the coefficients and the signs are those of 3D Gaussian splatting and gsplat. The basis is written as
polynomials of a unit vector; what they would be off the unit sphere is of no consequence, since the derivative is taken
through the normalisation, which removes its radial part.
"""

from __future__ import annotations

from typing import cast

import numpy as np
import torch
from torch import Tensor

from avs.rasterizer.kernels import Context, Floats, Integers, Number, Numbers, inline, kernel

MAX_DEGREE = 4
# Added to the sum of the harmonics, so that coefficients of 0 mean grey (3DGS, gsplat).
COLOR_OFFSET = 0.5

# Normalisation constants; for instance _C0 = sqrt(1 / (4 pi)) and _C1 = sqrt(3 / (4 pi)).
_C0 = np.float32(0.28209479177387814)
_C1 = np.float32(0.4886025119029199)
_C2 = np.array([1.0925484305920792, 0.31539156525252005, 0.5462742152960396], np.float32)
_C3 = np.array(
    [0.5900435899266435, 2.890611442640554, 0.4570457994644658, 0.3731763325901154, 1.445305721320277], np.float32
)
_C4 = np.array(
    [2.5033429417967046, 1.7701307697799304, 0.9461746957575601, 0.6690465435572892, 0.10578554691520431,
     0.47308734787878004, 0.6258357354491761],
    np.float32,
)  # fmt: skip


@inline
def evaluate_basis(degree: int, x: Number, y: Number, z: Number, basis: Floats) -> None:
    """Fill ``basis`` with the ``(degree + 1)^2`` functions at a unit vector."""
    basis[0] = _C0
    if degree >= 1:
        basis[1], basis[2], basis[3] = -_C1 * y, _C1 * z, -_C1 * x
    if degree >= 2:
        xx, yy, zz = x * x, y * y, z * z
        basis[4] = _C2[0] * x * y
        basis[5] = -_C2[0] * y * z
        basis[6] = _C2[1] * (zz + zz - xx - yy)
        basis[7] = -_C2[0] * x * z
        basis[8] = _C2[2] * (xx - yy)
        if degree >= 3:
            three = np.float32(3.0)
            four = np.float32(4.0)
            basis[9] = -_C3[0] * y * (three * xx - yy)
            basis[10] = _C3[1] * x * y * z
            basis[11] = -_C3[2] * y * (four * zz - xx - yy)
            basis[12] = _C3[3] * z * (zz + zz - three * (xx + yy))
            basis[13] = -_C3[2] * x * (four * zz - xx - yy)
            basis[14] = _C3[4] * z * (xx - yy)
            basis[15] = -_C3[0] * x * (xx - three * yy)
            if degree >= 4:
                one = np.float32(7.0) * zz - np.float32(1.0)
                other = np.float32(7.0) * zz - three
                basis[16] = _C4[0] * x * y * (xx - yy)
                basis[17] = -_C4[1] * y * z * (three * xx - yy)
                basis[18] = _C4[2] * x * y * one
                basis[19] = -_C4[3] * y * z * other
                basis[20] = _C4[4] * (zz * (np.float32(35.0) * zz - np.float32(30.0)) + three)
                basis[21] = -_C4[3] * x * z * other
                basis[22] = _C4[5] * (xx - yy) * one
                basis[23] = -_C4[1] * x * z * (xx - three * yy)
                basis[24] = _C4[6] * (xx * (xx - three * yy) - yy * (three * xx - yy))


# Long because its polynomials are written out, a line for each term.
@inline
def basis_gradient(degree: int, x: Number, y: Number, z: Number, t: Floats) -> Numbers:
    """Return the gradient at (x, y, z) of the sum of the basis functions weighted with ``t``."""
    vx = np.float32(0.0)
    vy = np.float32(0.0)
    vz = np.float32(0.0)
    if degree >= 1:
        vx, vy, vz = -_C1 * t[3], -_C1 * t[1], _C1 * t[2]
    if degree >= 2:
        two = np.float32(2.0)
        c = _C2
        vx += c[0] * (y * t[4] - z * t[7]) + two * x * (c[2] * t[8] - c[1] * t[6])
        vy += c[0] * (x * t[4] - z * t[5]) - two * y * (c[2] * t[8] + c[1] * t[6])
        vz += np.float32(4.0) * c[1] * z * t[6] - c[0] * (y * t[5] + x * t[7])
        if degree >= 3:
            xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
            three = np.float32(3.0)
            six = np.float32(6.0)
            eight = np.float32(8.0)
            c = _C3
            ring = np.float32(4.0) * zz - xx - yy
            vx += (
                -c[0] * (six * xy * t[9] + three * (xx - yy) * t[15])
                + c[1] * yz * t[10]
                + c[2] * (two * xy * t[11] - (ring - two * xx) * t[13])
                - six * c[3] * xz * t[12]
                + two * c[4] * xz * t[14]
            )
            vy += (
                -c[0] * (three * (xx - yy) * t[9] - six * xy * t[15])
                + c[1] * xz * t[10]
                + c[2] * (two * xy * t[13] - (ring - two * yy) * t[11])
                - six * c[3] * yz * t[12]
                - two * c[4] * yz * t[14]
            )
            vz += (
                c[1] * xy * t[10]
                - eight * c[2] * (yz * t[11] + xz * t[13])
                + three * c[3] * (zz + zz - xx - yy) * t[12]
                + c[4] * (xx - yy) * t[14]
            )
            if degree >= 4:
                c = _C4
                one = np.float32(7.0) * zz - np.float32(1.0)
                other = np.float32(7.0) * zz - three
                steep = np.float32(21.0) * zz - three
                fourteen = np.float32(14.0)
                cube_x = xx - three * yy
                cube_y = three * xx - yy
                vx += (
                    c[0] * y * cube_y * t[16]
                    - six * c[1] * x * yz * t[17]
                    + c[2] * y * one * t[18]
                    - c[3] * z * other * t[21]
                    + two * c[5] * x * one * t[22]
                    - three * c[1] * z * (xx - yy) * t[23]
                    + np.float32(4.0) * c[6] * x * cube_x * t[24]
                )
                vy += (
                    c[0] * x * cube_x * t[16]
                    - three * c[1] * z * (xx - yy) * t[17]
                    + c[2] * x * one * t[18]
                    - c[3] * z * other * t[19]
                    - two * c[5] * y * one * t[22]
                    + six * c[1] * x * yz * t[23]
                    - np.float32(4.0) * c[6] * y * cube_y * t[24]
                )
                vz += (
                    -c[1] * y * cube_y * t[17]
                    + fourteen * c[2] * xy * z * t[18]
                    - c[3] * (y * steep * t[19] + x * steep * t[21])
                    + c[4] * z * (np.float32(140.0) * zz - np.float32(60.0)) * t[20]
                    + fourteen * c[5] * z * (xx - yy) * t[22]
                    - c[1] * x * cube_x * t[23]
                )
    return vx, vy, vz


@kernel
def color_kernel(
    degree: int, means: Floats, centre: Floats, coefficients: Floats, radii: Integers, colors: Floats,
) -> None:  # fmt: skip
    """Fill ``colors [N, 3]`` for one camera; 0 for Gaussians out of sight."""
    basis = np.zeros(25, np.float32)
    terms = (degree + 1) ** 2
    for i in range(len(means)):
        if radii[i, 0] == 0:
            for c in range(3):
                colors[i, c] = np.float32(0.0)
            continue
        x, y, z = means[i, 0] - centre[0], means[i, 1] - centre[1], means[i, 2] - centre[2]
        scale = np.float32(1.0) / np.sqrt(x * x + y * y + z * z)
        evaluate_basis(degree, x * scale, y * scale, z * scale, basis)
        red = green = blue = np.float32(COLOR_OFFSET)
        for k in range(terms):
            red += basis[k] * coefficients[i, k, 0]
            green += basis[k] * coefficients[i, k, 1]
            blue += basis[k] * coefficients[i, k, 2]
        colors[i, 0] = max(red, np.float32(0.0))
        colors[i, 1] = max(green, np.float32(0.0))
        colors[i, 2] = max(blue, np.float32(0.0))


@kernel
def color_backward_kernel(
    degree: int, means: Floats, centre: Floats, coefficients: Floats, colors: Floats, v_colors: Floats,
    v_means: Floats, v_centre: Floats, v_coefficients: Floats,
) -> None:  # fmt: skip
    """Add the gradients of one camera; a channel that was held at 0 has none."""
    basis = np.zeros(25, np.float32)
    terms = (degree + 1) ** 2
    weights = np.zeros(25, np.float32)
    for i in range(len(means)):
        v = (
            v_colors[i, 0] if colors[i, 0] > 0 else np.float32(0.0),
            v_colors[i, 1] if colors[i, 1] > 0 else np.float32(0.0),
            v_colors[i, 2] if colors[i, 2] > 0 else np.float32(0.0),
        )
        if v[0] == 0 and v[1] == 0 and v[2] == 0:
            continue
        x, y, z = means[i, 0] - centre[0], means[i, 1] - centre[1], means[i, 2] - centre[2]
        scale = np.float32(1.0) / np.sqrt(x * x + y * y + z * z)
        x, y, z = x * scale, y * scale, z * scale
        evaluate_basis(degree, x, y, z, basis)
        for k in range(terms):
            weights[k] = v[0] * coefficients[i, k, 0] + v[1] * coefficients[i, k, 1] + v[2] * coefficients[i, k, 2]
            for c in range(3):
                v_coefficients[i, k, c] += basis[k] * v[c]
        gx, gy, gz = basis_gradient(degree, x, y, z, weights)
        radial = gx * x + gy * y + gz * z
        gradient = ((gx - radial * x) * scale, (gy - radial * y) * scale, (gz - radial * z) * scale)
        for k in range(3):
            v_means[i, k] += gradient[k]
            v_centre[k] -= gradient[k]


class _Colors(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Context, coefficients: Tensor, means: Tensor, centres: Tensor, radii: Tensor, degree: int
    ) -> Tensor:
        colors = torch.empty(len(centres), len(means), 3)
        for c in range(len(centres)):
            per_camera = coefficients[c] if coefficients.ndim == 4 else coefficients
            color_kernel(
                degree,
                means.detach().numpy(),
                centres[c].detach().numpy(),
                per_camera.detach().numpy(),
                radii[c].numpy(),
                colors[c].numpy(),
            )
        ctx.save_for_backward(coefficients, means, centres, colors)
        ctx.degree = degree
        return colors

    @staticmethod
    def backward(ctx: Context, v_colors: Tensor) -> tuple[Tensor | None, ...]:
        coefficients, means, centres, colors = ctx.saved_tensors
        v_coefficients, v_means = torch.zeros_like(coefficients), torch.zeros_like(means)
        v_centres = torch.zeros_like(centres)
        v_colors = v_colors.contiguous()
        for c in range(len(centres)):
            shared = coefficients.ndim == 3
            color_backward_kernel(
                ctx.degree,
                means.detach().numpy(),
                centres[c].detach().numpy(),
                (coefficients if shared else coefficients[c]).detach().numpy(),
                colors[c].detach().numpy(),
                v_colors[c].numpy(),
                v_means.numpy(),
                v_centres[c].numpy(),
                (v_coefficients if shared else v_coefficients[c]).numpy(),
            )
        return v_coefficients, v_means, v_centres, None, None


def view_dependent_colors(coefficients: Tensor, means: Tensor, centres: Tensor, radii: Tensor, degree: int) -> Tensor:
    """Return the colours ``[C, N, 3]`` that C cameras see: ``max(0.5 + harmonics, 0)``, as in gsplat.

    Args:
        coefficients: ``[N, K, 3]`` or, per camera, ``[C, N, K, 3]``.
        means: centres of the Gaussians ``[N, 3]``.
        centres: camera centres ``[C, 3]``.
        radii: ``[C, N, 2]``; Gaussians of radius 0 are skipped and get 0.
        degree: highest degree to evaluate, at most 4 and with ``(degree + 1)^2 <= K``.
    """
    return cast(Tensor, _Colors.apply(coefficients, means, centres, radii, degree))  # type: ignore[no-untyped-call]
