"""Kernels of the diagonal Fisher information: second moments over pixels, and the chain to the parameters.

A pixel's channel sum depends on a Gaussian through seven numbers: centre (2), conic (3), opacity (1), colour (1). With
g = alpha dL/d alpha as in the backward pass and (dx, dy) the pixel relative to the centre, its derivatives by the first
six are g times linear combinations of 1, dx, dy, dx^2, dx dy and dy^2, and the weight w = alpha T by the last. What is
summed over pixels for each Gaussian are therefore the moments g^2 dx^i dy^j (i + j <= 4), g w dx^i dy^j (i + j <= 2)
and w^2: 22 sums, from which the sum of squares of any linear combination follows exactly. The chain from the seven
numbers to the parameters is linear for each Gaussian, so that it is applied once per Gaussian rather than once per
pixel.
"""

import numpy as np

from avs.representations.gaussians.blending import (
    ALPHA_MAX,
    BLOCKS,
    PIXELS,
    TRANSMITTANCE_MIN,
    live_blocks,
    pixel_centres,
)  # fmt: skip
from avs.representations.gaussians.ewa import project_backward
from avs.representations.gaussians.kernels import Floats, Integers, Number, Numbers, inline, kernel
from avs.representations.gaussians.records import COLOR, LOG2_ALPHA_MIN, LOG_OPACITY, XX, XY, YY, X, Y
from avs.representations.gaussians.simd import LANES, any_of, broadcast, exp2, fma, minimum, where
from avs.representations.gaussians.simd_memory import aligned_empty, load, store, sum_lanes
from avs.representations.gaussians.spherical_harmonics import basis_gradient, evaluate_basis
from avs.representations.gaussians.tiles import TILE

# Columns of the moments: g^2 dx^i dy^j at _SQUARE[i][j], g w dx^i dy^j at _CROSS[i][j], w^2.
_SQUARE = ((0, 1, 2, 3, 4), (5, 6, 7, 8, -1), (9, 10, 11, -1, -1), (12, 13, -1, -1, -1), (14, -1, -1, -1, -1))
_CROSS = ((15, 16, 17), (18, 19, -1), (20, -1, -1))
WEIGHT = 21
MOMENTS = 22
# Exponents (i, j) of the monomials dx, dy, dx^2, dx dy, dy^2, 1.
_POWERS = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (0, 0))


@kernel
def second_moments(
    records: Floats, entries: Integers, offsets: Integers, transmittance: Floats, pixels: Floats,
    background: Number, width: int, height: int,
) -> Floats:  # fmt: skip
    """Return the moments ``[M, 22]`` of each record, whose single channel is the sum of the colour's.

    The arguments after ``records`` are what :func:`~avs.representations.gaussians.blending.blend` returned for them,
    but for ``background``, the sum of its channels.
    """
    columns, rows = (width + TILE - 1) // TILE, (height + TILE - 1) // TILE
    moments = np.zeros((len(records), MOMENTS))
    scratch = aligned_empty(2 * PIXELS)
    column, row = pixel_centres()
    for tile in range(columns * rows):
        x, y = TILE * (tile % columns), TILE * (tile // columns)
        for p in range(PIXELS):
            inside = x + p % TILE < width and y + p // TILE < height
            scratch[p] = np.float32(1.0) if inside else np.float32(-1.0)
            blended = np.float32(1.0) - abs(transmittance[tile * PIXELS + p])
            scratch[PIXELS + p] = pixels[tile * PIXELS + p] - background * blended
        live = (1 << BLOCKS) - 1
        for chunk in range(len(offsets)):
            if live:
                live = _moments_of_tile(
                    records, entries, offsets[chunk, tile], offsets[chunk, tile + 1],
                    column + np.float32(x), row + np.float32(y), background, live, scratch, moments,
                )  # fmt: skip
    return moments


@inline
def _moments_of_tile(
    records: Floats, entries: Integers, start: int, end: int, x: Number, y: Number, background: Number, live: int,
    scratch: Floats, moments: Floats,
) -> int:  # fmt: skip
    """Add a list's moments; the same decisions as in the forward pass. Return the live blocks."""
    flat = records.reshape(-1)
    for e in range(start, end):
        place = entries[e]
        at = place * records.shape[1]
        dx = x - flat[at + X]
        quadratic = (flat[at + XX] * dx) * dx
        mixed = flat[at + XY] * dx
        inner = flat[at + COLOR] - background
        stopped = False
        blends = False
        s0 = s1 = s2 = s3 = s4 = c0 = c1 = c2 = weights = broadcast(0.0)
        for block in range(BLOCKS):
            if not live & (1 << block):
                continue
            here = block * LANES
            dy = y - (flat[at + Y] - np.float32(2 * block))
            power = fma(dy, fma(dy, flat[at + YY], mixed), quadratic)
            exponent = power + flat[at + LOG_OPACITY]
            light = load(scratch, here)
            touched = (exponent >= LOG2_ALPHA_MIN) & (power <= 0.0) & (light > 0.0)
            if any_of(touched):
                unclamped = exp2(exponent)
                alpha = minimum(unclamped, ALPHA_MAX)
                onward = light * (1.0 - alpha)
                blended = touched & (onward > TRANSMITTANCE_MIN)
                stops = touched & (onward <= TRANSMITTANCE_MIN)
                weight = where(blended, alpha * light, 0.0)
                store(scratch, here, where(blended, onward, light))
                if any_of(stops):
                    store(scratch, here, where(blended, onward, where(stops, -light, light)))
                    stopped = True
                blends = True
                rest = load(scratch, PIXELS + here) - weight * inner
                store(scratch, PIXELS + here, rest)
                v_alpha = (onward * inner - rest) / (1.0 - alpha)
                g = where(blended & (unclamped <= ALPHA_MAX), alpha * v_alpha, 0.0)
                square, cross, dy2 = g * g, g * weight, dy * dy
                s0 = s0 + square
                s1 = fma(square, dy, s1)
                s2 = fma(square, dy2, s2)
                s3 = fma(square * dy, dy2, s3)
                s4 = fma(square * dy2, dy2, s4)
                c0 = c0 + cross
                c1 = fma(cross, dy, c1)
                c2 = fma(cross, dy2, c2)
                weights = fma(weight, weight, weights)
        if blends:
            m = moments[place]
            for i in range(5):
                m[i] += sum_lanes((s0, s1, s2, s3, s4)[i])
            for i in range(3):
                m[15 + i] += sum_lanes((c0, c1, c2)[i])
            s0, s1, s2, s3, c0, c1 = s0 * dx, s1 * dx, s2 * dx, s3 * dx, c0 * dx, c1 * dx
            m[5] += sum_lanes(s0)
            m[6] += sum_lanes(s1)
            m[7] += sum_lanes(s2)
            m[8] += sum_lanes(s3)
            m[18] += sum_lanes(c0)
            m[19] += sum_lanes(c1)
            s0, s1, s2 = s0 * dx, s1 * dx, s2 * dx
            m[9] += sum_lanes(s0)
            m[10] += sum_lanes(s1)
            m[11] += sum_lanes(s2)
            m[20] += sum_lanes(c0 * dx)
            s0, s1 = s0 * dx, s1 * dx
            m[12] += sum_lanes(s0)
            m[13] += sum_lanes(s1)
            m[14] += sum_lanes(s0 * dx)
            m[WEIGHT] += sum_lanes(weights)
        if stopped:
            live = live_blocks(scratch, 0)
            if live == 0:
                break
    return live


@inline
def _sum_of_squares(moments: Floats, coefficients: Floats, of_color: float) -> float:
    """Return the sum over pixels of (g times a polynomial + ``of_color`` times w)^2.

    ``coefficients`` are those of dx, dy, dx^2, dx dy, dy^2 and 1. Rounding may leave a sum of squares that is 0
    slightly negative, hence the bound.
    """
    total: float = of_color * of_color * moments[WEIGHT]
    for a in range(6):
        i, j = _POWERS[a]
        total += 2.0 * of_color * coefficients[a] * moments[_CROSS[i][j]]
        for b in range(6):
            k, l = _POWERS[b]  # noqa: E741
            total += coefficients[a] * coefficients[b] * moments[_SQUARE[i + k][j + l]]
    return max(total, 0.0)


@inline
def _derivatives(
    rows: Floats, pose: Numbers, lens: Numbers, eps2d: Number, unit: Floats,
) -> tuple[Numbers, Numbers, Numbers]:  # fmt: skip
    """Return the derivatives of one of x, y, conic (3) and compensation by centre, quaternion and scale."""
    v_mean, v_quat, v_scale, _ = project_backward(
        (load(rows, 0), load(rows, 16), load(rows, 32)),
        (load(rows, 48), load(rows, 64), load(rows, 80), load(rows, 96)),
        (load(rows, 112), load(rows, 128), load(rows, 144)),
        pose,
        lens,
        eps2d,
        (load(rows, 160), load(rows, 176), load(rows, 192)),
        load(rows, 208),
        (broadcast(unit[0]), broadcast(unit[1])),
        broadcast(0.0),
        (broadcast(unit[2]), broadcast(unit[3]), broadcast(unit[4])),
        broadcast(unit[5]),
    )
    return v_mean, v_quat, v_scale


@kernel
def apply_chain(
    order: Integers, moments: Floats, means: Floats, quats: Floats, scales: Floats, opacities: Floats,
    effective: Floats, coefficients: Floats, colors: Floats, conics: Floats, compensations: Floats, pose: Numbers,
    lens: Numbers, centre: Floats, eps2d: Number, degree: int, antialiased: bool, of_means: Floats,
    of_quats: Floats, of_scales: Floats, of_opacities: Floats, of_coefficients: Floats,
) -> None:  # fmt: skip
    """Fill the diagonal for each Gaussian that was blended somewhere; it is 0 for the others."""
    places = np.empty(len(order), np.int32)
    size = 0
    for place in range(len(order)):
        if moments[place, WEIGHT] > 0:
            places[size] = place
            size += 1
    rows = np.zeros(14 * LANES, np.float32)
    # derivative of quantity q by parameter p for one of the sixteen: [q, p, lane]
    jacobian = np.empty((6, 10, LANES), np.float32)
    flat = jacobian.reshape(-1)
    unit = np.empty(6, np.float32)
    basis = np.zeros(25, np.float32)
    weights = np.zeros(25, np.float32)
    by_color = np.zeros(10)
    c = np.zeros(6)
    terms = (degree + 1) ** 2
    for start in range(0, size, LANES):
        for lane in range(LANES):
            i = order[places[min(start + lane, size - 1)]]
            for k in range(3):
                rows[k * LANES + lane] = means[i, k]
                rows[(7 + k) * LANES + lane] = scales[i, k]
                rows[(10 + k) * LANES + lane] = conics[i, k]
            for k in range(4):
                rows[(3 + k) * LANES + lane] = quats[i, k]
            rows[13 * LANES + lane] = compensations[i]
        for q in range(6 if antialiased else 5):
            for k in range(6):
                unit[k] = np.float32(1.0 if k == q else 0.0)
            v_mean, v_quat, v_scale = _derivatives(rows, pose, lens, eps2d, unit)
            to = 10 * LANES * q
            store(flat, to, v_mean[0])
            store(flat, to + 16, v_mean[1])
            store(flat, to + 32, v_mean[2])
            store(flat, to + 48, v_quat[0])
            store(flat, to + 64, v_quat[1])
            store(flat, to + 80, v_quat[2])
            store(flat, to + 96, v_quat[3])
            store(flat, to + 112, v_scale[0])
            store(flat, to + 128, v_scale[1])
            store(flat, to + 144, v_scale[2])
        for lane in range(min(LANES, size - start)):
            place = places[start + lane]
            i = order[place]
            m = moments[place]
            x, y, z = means[i, 0] - centre[0], means[i, 1] - centre[1], means[i, 2] - centre[2]
            scale = np.float32(1.0) / np.sqrt(x * x + y * y + z * z)
            x, y, z = x * scale, y * scale, z * scale
            evaluate_basis(degree, x, y, z, basis)
            for k in range(terms):
                weights[k] = np.float32(0.0)
                for channel in range(3):
                    if colors[i, channel] > 0:
                        weights[k] += coefficients[i, k, channel]
                        of_coefficients[i, k, channel] = np.float64(basis[k]) ** 2 * m[WEIGHT]
            gx, gy, gz = basis_gradient(degree, x, y, z, weights)
            radial = gx * x + gy * y + gz * z
            by_color[0] = (gx - radial * x) * scale
            by_color[1] = (gy - radial * y) * scale
            by_color[2] = (gz - radial * z) * scale
            for p in range(10):
                j = jacobian[:, p, lane]
                c[0] = conics[i, 0] * j[0] + conics[i, 1] * j[1]
                c[1] = conics[i, 1] * j[0] + conics[i, 2] * j[1]
                c[2] = -0.5 * j[2]
                c[3] = -j[3]
                c[4] = -0.5 * j[4]
                c[5] = j[5] / compensations[i] if antialiased else 0.0
                value = _sum_of_squares(m, c, by_color[p])
                if p < 3:
                    of_means[i, p] = value
                elif p < 7:
                    of_quats[i, p - 3] = value
                else:
                    of_scales[i, p - 7] = value
            of_opacities[i] = m[0] / np.float64(opacities[i]) ** 2
