"""From second moments over pixels to the diagonal Fisher information of each Gaussian's parameters.

The chain from centre, conic, opacity and colour in the image to the parameters is linear for each Gaussian: the
derivative of a pixel by a parameter is g times a polynomial of second degree plus a multiple of w, and the sum of its
squares a quadratic form of the moments. The letters are those of ``fisher_moments.py``.
"""

import numpy as np

from avs.rasterizer.ewa import project_backward
from avs.rasterizer.fisher_moments import (
    G00,
    G01,
    G02,
    G03,
    G04,
    G10,
    G11,
    G12,
    G13,
    G20,
    G21,
    G22,
    G30,
    G31,
    G40,
    MOMENTS,
    W00,
    W01,
    W02,
    W10,
    W11,
    W20,
    WEIGHT,
)
from avs.rasterizer.gaussian_rows import (
    COMPENSATION,
    CONIC,
    MEAN,
    QUAT,
    ROWS,
    SCALE,
    gather_gaussian,
    load_gaussian,
)
from avs.rasterizer.kernels import Floats, Integers, Number, Numbers, inline, kernel
from avs.rasterizer.simd import broadcast
from avs.rasterizer.simd_memory import load, load_rows, store_rows
from avs.rasterizer.simd_types import LANES
from avs.rasterizer.spherical_harmonics import basis_gradient, evaluate_basis

# Where the rows of one combination of ``units`` begin: the factors of the derivatives of centre in the image (2), conic
# (3) and compensation.
_OF_IMAGE, _OF_CONIC, _OF_COMPENSATION = (LANES * row for row in (0, 2, 5))


@inline
def _sum_of_squares(
    m: Floats, x: float, u: float, xx: float, xu: float, uu: float, one: float, color: float,
) -> float:  # fmt: skip
    """Return the sum over pixels of (g (x dx + u u + xx dx^2 + xu dx u + uu u^2 + one) + color w)^2 from the moments.

    Rounding may make a sum of squares that is 0 slightly negative; the bound prevents it.
    """
    total: float = x * (x * m[G20] + 2.0 * (u * m[G11] + xx * m[G30] + xu * m[G21] + uu * m[G12]))
    total += u * (u * m[G02] + 2.0 * (xx * m[G21] + xu * m[G12] + uu * m[G03]))
    total += (
        xx * (xx * m[G40] + 2.0 * (xu * m[G31] + uu * m[G22]))
        + xu * (xu * m[G22] + 2.0 * uu * m[G13])
        + uu * uu * m[G04]
    )
    total += one * (one * m[G00] + 2.0 * (x * m[G10] + u * m[G01] + xx * m[G20] + xu * m[G11] + uu * m[G02]))
    mixed = x * m[W10] + u * m[W01] + xx * m[W20] + xu * m[W11] + uu * m[W02] + one * m[W00]
    total += color * (color * m[WEIGHT] + 2.0 * mixed)
    return max(total, 0.0)


@inline
def _set_units(
    units: Floats, lane: int, t: float, a: float, b: float, c: float, compensation: float,
) -> None:  # fmt: skip
    """Set the combinations of x, y, conic (A, B, C) and compensation that are the coefficients of a pixel's derivative.

    ``units`` is ``[6, 6, 16]``: the coefficients of dx, u, dx^2, dx u, u^2 and 1. That of dx^2, for one, is
    -(dA - 2 t dB + t^2 dC) / 2: combined before rather than after the derivatives by the parameters are taken, so that
    the large parts of a thin Gaussian's conic cancel before they are rounded.
    """
    units[0, 0, lane], units[0, 1, lane] = a - t * b, b - t * c
    units[1, 0, lane], units[1, 1, lane] = b, c
    units[2, 2, lane], units[2, 3, lane], units[2, 4, lane] = -0.5, t, -0.5 * t * t
    units[3, 3, lane], units[3, 4, lane] = -1.0, t
    units[4, 4, lane] = -0.5
    units[5, 5, lane] = 1.0 / compensation


@inline
def _derivatives(
    rows: Floats, pose: Numbers, lens: Numbers, eps2d: Number, units: Floats, at: int, jacobian: Floats, to: int,
) -> None:  # fmt: skip
    """Store the derivatives by centre, quaternion and scale of the combination at ``at`` of ``units``."""
    mean, quat, scale = load_gaussian(rows)
    v_mean, v_quat, v_scale, _ = project_backward(
        mean, quat, scale, pose, lens, eps2d, load_rows(rows, CONIC, 3), load(rows, COMPENSATION),
        load_rows(units, at + _OF_IMAGE, 2), broadcast(0.0), load_rows(units, at + _OF_CONIC, 3),
        load(units, at + _OF_COMPENSATION),
    )  # fmt: skip
    store_rows(jacobian, to + MEAN, v_mean)
    store_rows(jacobian, to + QUAT, v_quat)
    store_rows(jacobian, to + SCALE, v_scale)


# Long because sixteen Gaussians are gathered into vectors and scattered again, as in ``projection.py``.
@kernel
def apply_chain(
    gaussians: Integers, places: Integers, moments: Floats, shears: Floats, means: Floats, quats: Floats,
    scales: Floats, opacities: Floats, coefficients: Floats, colors: Floats, conics: Floats, compensations: Floats,
    pose: Numbers, lens: Numbers, centre: Floats, eps2d: Number, degree: int, antialiased: bool, of_means: Floats,
    of_quats: Floats, of_scales: Floats, of_opacities: Floats, of_coefficients: Floats,
) -> None:  # fmt: skip
    """Fill the diagonal, row r of which is that of Gaussian ``gaussians[r]``, whose moments are at ``places[r]``.

    Quaternions are left out where ``of_quats`` has no rows.
    """
    size = len(gaussians)
    rows = np.empty(ROWS, np.float32)
    units = np.zeros((6, 6, LANES), np.float32)
    # derivative of coefficient q by parameter p for one of the sixteen: [q, p, lane]
    jacobian = np.zeros((6, 10, LANES), np.float32)
    basis = np.zeros(25, np.float32)
    weights = np.zeros(25, np.float32)
    by_color = np.zeros(10)
    m = np.zeros(MOMENTS)
    terms = (degree + 1) ** 2
    for start in range(0, size, LANES):
        for lane in range(LANES):
            r = min(start + lane, size - 1)
            i = gaussians[r]
            gather_gaussian(rows, lane, means, quats, scales, i)
            for k in range(3):
                rows[CONIC + k * LANES + lane] = conics[i, k]
            rows[COMPENSATION + lane] = compensations[i]
            t = np.float64(shears[places[r]])
            a, b, c = np.float64(conics[i, 0]), np.float64(conics[i, 1]), np.float64(conics[i, 2])
            _set_units(units, lane, t, a, b, c, np.float64(compensations[i]))
        for q in range(6 if antialiased else 5):
            _derivatives(
                rows, pose, lens, eps2d, units.reshape(-1), 6 * LANES * q, jacobian.reshape(-1), 10 * LANES * q
            )
        for lane in range(min(LANES, size - start)):
            r = start + lane
            i = gaussians[r]
            for k in range(MOMENTS):
                m[k] = moments[places[r], k]
            x, y, z = means[i, 0] - centre[0], means[i, 1] - centre[1], means[i, 2] - centre[2]
            scale = np.float32(1.0) / np.sqrt(x * x + y * y + z * z)
            x, y, z = x * scale, y * scale, z * scale
            evaluate_basis(degree, x, y, z, basis)
            for k in range(terms):
                square = np.float32(np.float64(basis[k]) * basis[k] * m[WEIGHT])
                weights[k] = np.float32(0.0)
                for channel in range(3):
                    if colors[i, channel] > 0:
                        weights[k] += coefficients[i, k, channel]
                        of_coefficients[r, k, channel] = square
            gx, gy, gz = basis_gradient(degree, x, y, z, weights)
            radial = gx * x + gy * y + gz * z
            by_color[0] = (gx - radial * x) * scale
            by_color[1] = (gy - radial * y) * scale
            by_color[2] = (gz - radial * z) * scale
            for p in range(10):
                if 3 <= p < 7 and len(of_quats) == 0:
                    continue
                value = _sum_of_squares(
                    m, np.float64(jacobian[0, p, lane]), np.float64(jacobian[1, p, lane]),
                    np.float64(jacobian[2, p, lane]), np.float64(jacobian[3, p, lane]),
                    np.float64(jacobian[4, p, lane]), np.float64(jacobian[5, p, lane]), by_color[p],
                )  # fmt: skip
                if p < 3:
                    of_means[r, p] = value
                elif p < 7:
                    of_quats[r, p - 3] = value
                else:
                    of_scales[r, p - 7] = value
            of_opacities[r] = m[G00] / np.float64(opacities[i]) ** 2
