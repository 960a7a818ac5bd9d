"""From second moments over pixels to the diagonal Fisher information of each Gaussian's parameters.

The chain from centre, conic, opacity and colour in the image to the parameters is linear for each Gaussian: the
derivative of a pixel by a parameter is g times a polynomial of second degree plus a multiple of w, and the sum of its
squares a quadratic form of the moments. The letters are those of ``fisher_moments.py``.
"""

import numpy as np

from avs.rasterizer.ewa import project_backward
from avs.rasterizer.fisher_moments import MOMENTS, WEIGHT
from avs.rasterizer.kernels import Floats, Integers, Number, Numbers, inline, kernel
from avs.rasterizer.simd import LANES, broadcast
from avs.rasterizer.simd_memory import load, store
from avs.rasterizer.spherical_harmonics import basis_gradient, evaluate_basis


@inline
def _sum_of_squares(
    m: Floats, x: float, u: float, xx: float, xu: float, uu: float, one: float, color: float,
) -> float:  # fmt: skip
    """Return the sum over pixels of (g (x dx + u u + xx dx^2 + xu dx u + uu u^2 + one) + color w)^2 from the moments.

    Rounding may make a sum of squares that is 0 slightly negative; the bound prevents it.
    """
    total: float = x * (x * m[9] + 2.0 * (u * m[6] + xx * m[12] + xu * m[10] + uu * m[7]))
    total += u * (u * m[2] + 2.0 * (xx * m[10] + xu * m[7] + uu * m[3]))
    total += xx * (xx * m[14] + 2.0 * (xu * m[13] + uu * m[11])) + xu * (xu * m[11] + 2.0 * uu * m[8]) + uu * uu * m[4]
    total += one * (one * m[0] + 2.0 * (x * m[5] + u * m[1] + xx * m[9] + xu * m[6] + uu * m[2]))
    mixed = x * m[18] + u * m[16] + xx * m[20] + xu * m[19] + uu * m[17] + one * m[15]
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
    v_mean, v_quat, v_scale, _ = project_backward(
        (load(rows, 0), load(rows, 16), load(rows, 32)),
        (load(rows, 48), load(rows, 64), load(rows, 80), load(rows, 96)),
        (load(rows, 112), load(rows, 128), load(rows, 144)),
        pose,
        lens,
        eps2d,
        (load(rows, 160), load(rows, 176), load(rows, 192)),
        load(rows, 208),
        (load(units, at), load(units, at + 16)),
        broadcast(0.0),
        (load(units, at + 32), load(units, at + 48), load(units, at + 64)),
        load(units, at + 80),
    )
    store(jacobian, to, v_mean[0])
    store(jacobian, to + 16, v_mean[1])
    store(jacobian, to + 32, v_mean[2])
    store(jacobian, to + 48, v_quat[0])
    store(jacobian, to + 64, v_quat[1])
    store(jacobian, to + 80, v_quat[2])
    store(jacobian, to + 96, v_quat[3])
    store(jacobian, to + 112, v_scale[0])
    store(jacobian, to + 128, v_scale[1])
    store(jacobian, to + 144, v_scale[2])


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
    rows = np.empty(14 * LANES, np.float32)
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
            for k in range(3):
                rows[k * LANES + lane] = means[i, k]
                rows[(7 + k) * LANES + lane] = scales[i, k]
                rows[(10 + k) * LANES + lane] = conics[i, k]
            for k in range(4):
                rows[(3 + k) * LANES + lane] = quats[i, k]
            rows[13 * LANES + lane] = compensations[i]
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
            of_opacities[r] = m[0] / np.float64(opacities[i]) ** 2
