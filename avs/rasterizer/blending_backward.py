"""Backward pass of the blending, front to back with recomputed opacities.

With the weights w_j = alpha_j T_j of the Gaussians blended into a pixel and u_j = c_j . v + v_alpha (v: gradients of
the pixel's channels and alpha), the sum R = sum_j w_j u_j is known from the rendered pixel, and

    dL/d alpha_i = T_i u_i - (R - sum_{j <= i} w_j u_j) / (1 - alpha_i).

A channel of squared weights, sum_j c_j w_j^2, adds 2 c_j w_j v to u_j, or nothing where it is to move no Gaussian.

So no list of blended Gaussians is kept and no transmittance is divided out; the opacities are recomputed by the very
functions of the forward pass, and each pixel stops where it stopped there.

With g = alpha_i dL/d alpha_i, all gradients of centre, conic and opacity are linear in the sums over pixels of g, g dx,
g dy, g dx^2, g dx dy and g dy^2; only those six are accumulated. As one thread goes through the tiles in order, sums
are always taken in the same order.
"""

import numpy as np

from avs.rasterizer.blending_decision import (
    BLOCKS,
    PIXELS,
    PREFETCH,
    attenuate,
    column_terms,
    live_blocks,
    pixel_centres,
    start_tile,
    touch,
)
from avs.rasterizer.constants import ALPHA_MAX
from avs.rasterizer.kernels import Floats, Integers, Number, inline, kernel
from avs.rasterizer.simd import absolute, any_of, broadcast, fma, where
from avs.rasterizer.simd_memory import add_row_sums, aligned_empty, aligned_full, load, prefetch, store
from avs.rasterizer.simd_types import LANES
from avs.rasterizer.splat_records import COLOR, LOG2_E, XX, XY, YY
from avs.rasterizer.tiles import TILE

# Columns of the sums kept for each Gaussian; from CHANNELS on the gradients of the channels, plain ones before those of
# squared weights, then the absolute gradients.
SUM, SUM_X, SUM_Y, SUM_XX, SUM_XY, SUM_YY, CHANNELS = 0, 1, 2, 3, 4, 5, 6

# Layout of a tile's scratch memory: transmittance, remaining sum, gradient of alpha and gradients of the channels of
# its pixels; after those one vector for each of the sums.
_LIGHT, _REST, _V_ALPHA, _V_COLOR = 0, PIXELS, 2 * PIXELS, 3 * PIXELS


@inline
def _load_tile(
    scratch: Floats, channels: tuple[int, ...], squares: tuple[int, ...], through: float, tile: int, x: Number,
    y: Number, transmittance: Floats, pixels: Floats, background: Floats, v_image: Floats, v_alpha: Floats,
) -> int:  # fmt: skip
    """Fill the scratch memory for a tile whose first pixel is (x, y). Return the live blocks."""
    height, width = v_alpha.shape
    planes = len(channels) + len(squares)
    live: int = start_tile(scratch, _LIGHT, x, y, width, height)
    for p in range(PIXELS):
        column, row = x + p % TILE, y + p // TILE
        if scratch[_LIGHT + p] < 0:
            scratch[_REST + p] = scratch[_V_ALPHA + p] = np.float32(0.0)
            for c in range(planes):
                scratch[_V_COLOR + c * PIXELS + p] = np.float32(0.0)
            continue
        v = v_alpha[row, column]
        rest = np.float32(0.0)
        for c in range(len(channels)):
            v_channel = v_image[row, column, c]
            scratch[_V_COLOR + c * PIXELS + p] = v_channel
            v -= v_channel * background[c]
            rest += v_channel * pixels[(tile * planes + c) * PIXELS + p]
        for c in range(len(channels), planes):
            v_channel = v_image[row, column, c]
            scratch[_V_COLOR + c * PIXELS + p] = v_channel
            rest += np.float32(2.0 * through) * v_channel * pixels[(tile * planes + c) * PIXELS + p]
        scratch[_V_ALPHA + p] = v
        scratch[_REST + p] = rest + v * (np.float32(1.0) - abs(transmittance[tile * PIXELS + p]))
    return live


# Long because the sums over a tile are local vectors, which stay in registers: an inlined function cannot add to
# those of its caller.
@inline
def _gradients_of_tile(
    records: Floats, entries: Integers, start: int, end: int, x: Number, y: Number, channels: tuple[int, ...],
    squares: tuple[int, ...], through: float, like: tuple[int, ...], live: int, scratch: Floats, sums: Floats,
) -> int:  # fmt: skip
    """Add a list's gradients to ``sums``. Return the live blocks."""
    flat, flat_sums = records.reshape(-1), sums.reshape(-1)
    width = records.shape[1]
    planes = len(channels) + len(squares)
    rows = _V_COLOR + planes * PIXELS
    row_of_color = rows + CHANNELS * LANES
    row_of_absolute = row_of_color + planes * LANES
    absgrad = len(like) > CHANNELS + planes
    for e in range(start, end):
        ahead = entries[min(e + PREFETCH, end - 1)]
        prefetch(flat, ahead * width)
        prefetch(flat_sums, ahead * sums.shape[1])
        at = entries[e] * width
        dx, quadratic, mixed, log_opacity = column_terms(flat, at, x)
        stopped = False
        blends = False
        sum_0 = broadcast(0.0)
        sum_y = broadcast(0.0)
        sum_yy = broadcast(0.0)
        absolute_x = broadcast(0.0)
        absolute_y = broadcast(0.0)
        for c in range(planes):
            store(scratch, row_of_color + c * LANES, broadcast(0.0))
        for block in range(BLOCKS):
            if not live & (1 << block):
                continue
            here = block * LANES
            light = load(scratch, _LIGHT + here)
            dy, exponent, touched = touch(flat, at, y, block, quadratic, mixed, log_opacity, light, 0.0)
            if any_of(touched):
                unclamped, alpha, onward, blended, left, stops = attenuate(exponent, touched, light)
                store(scratch, _LIGHT + here, left)
                stopped |= stops
                blends = True
                weight = where(blended, alpha * light, 0.0)
                inner = load(scratch, _V_ALPHA + here)
                for c in range(len(channels)):
                    v_channel = load(scratch, _V_COLOR + c * PIXELS + here)
                    inner = fma(v_channel, flat[at + COLOR + c], inner)
                    at_sum = row_of_color + c * LANES
                    store(scratch, at_sum, fma(weight, v_channel, load(scratch, at_sum)))
                for c in range(len(channels), planes):
                    by_weight = weight * load(scratch, _V_COLOR + c * PIXELS + here)
                    inner = fma(by_weight, 2.0 * through * flat[at + COLOR + c], inner)
                    at_sum = row_of_color + c * LANES
                    store(scratch, at_sum, fma(weight, by_weight, load(scratch, at_sum)))
                rest = load(scratch, _REST + here) - weight * inner
                store(scratch, _REST + here, rest)
                v_alpha = (onward * inner - rest) / (1.0 - alpha)
                g = where(blended & (unclamped <= ALPHA_MAX), alpha * v_alpha, 0.0)
                g_y = g * dy
                sum_0 = sum_0 + g
                sum_y = sum_y + g_y
                sum_yy = fma(g_y, dy, sum_yy)
                if absgrad:
                    absolute_x = absolute_x + absolute(g * fma(flat[at + XX] * 2.0, dx, flat[at + XY] * dy))
                    absolute_y = absolute_y + absolute(g * fma(flat[at + YY] * 2.0, dy, mixed))
        if blends:
            sum_x = sum_0 * dx
            store(scratch, rows + SUM * LANES, sum_0)
            store(scratch, rows + SUM_X * LANES, sum_x)
            store(scratch, rows + SUM_Y * LANES, sum_y)
            store(scratch, rows + SUM_XX * LANES, sum_x * dx)
            store(scratch, rows + SUM_XY * LANES, sum_y * dx)
            store(scratch, rows + SUM_YY * LANES, sum_yy)
            if absgrad:
                store(scratch, row_of_absolute, absolute_x)
                store(scratch, row_of_absolute + LANES, absolute_y)
            add_row_sums(scratch, rows, like, flat_sums, entries[e] * sums.shape[1])
        if stopped:
            live = live_blocks(scratch, _LIGHT)
            if live == 0:
                break
    return live


@kernel
def blend_backward(
    records: Floats, entries: Integers, offsets: Integers, transmittance: Floats, pixels: Floats,
    channels: tuple[int, ...], squares: tuple[int, ...], through: float, like: tuple[int, ...],
    background: Floats, v_image: Floats, v_alpha: Floats,
) -> Floats:  # fmt: skip
    """Return, per record, the sums named by ``SUM`` to ``SUM_YY``, the gradients of the channels, and |x|, |y|.

    The last two, sums over pixels of the absolute gradients of the centre, only where the tuple ``like`` is long enough
    for them: ``CHANNELS + channels + squares + 2``. ``through``: 1, or 0 where a channel of squared weights is
    differentiated by its values alone.
    """
    height, width = v_alpha.shape
    columns, rows = (width + TILE - 1) // TILE, (height + TILE - 1) // TILE
    width_of_sums = (len(like) + LANES - 1) // LANES * LANES
    sums: Floats = aligned_full(len(records) * width_of_sums, 0.0).reshape((len(records), width_of_sums))
    scratch = aligned_empty(_V_COLOR + (len(channels) + len(squares)) * PIXELS + len(like) * LANES)
    column, row = pixel_centres()
    for tile in range(columns * rows):
        x, y = TILE * (tile % columns), TILE * (tile // columns)
        live = -1
        for chunk in range(len(offsets)):
            start, end = offsets[chunk, tile], offsets[chunk, tile + 1]
            if start == end or live == 0:
                continue
            if live < 0:
                live = _load_tile(
                    scratch, channels, squares, through, tile, x, y, transmittance, pixels, background, v_image, v_alpha
                )  # fmt: skip
            live = _gradients_of_tile(
                records, entries, start, end, column + np.float32(x), row + np.float32(y),
                channels, squares, through, like, live, scratch, sums,
            )  # fmt: skip
    return sums


@kernel
def unpack_gradients(
    order: Integers, conics: Floats, opacities: Floats, sums: Floats, absgrad: bool, with_depth: bool,
    v_means2d: Floats, v_absolute: Floats, v_conics: Floats, v_opacities: Floats, v_colors: Floats,
    v_depths: Floats,
) -> None:  # fmt: skip
    """Add one camera's sums, in depth order, to the gradients of the Gaussians in their own order."""
    channels = v_colors.shape[1]
    for place in range(len(order)):
        untouched = sums[place, SUM] == 0
        for k in range(channels + with_depth):
            untouched &= sums[place, CHANNELS + k] == 0
        if untouched:
            continue
        i = order[place]
        a, b, c = conics[i, 0], conics[i, 1], conics[i, 2]
        v_means2d[i, 0] = a * sums[place, SUM_X] + b * sums[place, SUM_Y]
        v_means2d[i, 1] = b * sums[place, SUM_X] + c * sums[place, SUM_Y]
        v_conics[i, 0] = np.float32(-0.5) * sums[place, SUM_XX]
        v_conics[i, 1] = -sums[place, SUM_XY]
        v_conics[i, 2] = np.float32(-0.5) * sums[place, SUM_YY]
        v_opacities[i] += sums[place, SUM] / opacities[i]
        for k in range(channels):
            v_colors[i, k] += sums[place, CHANNELS + k]
        if with_depth:
            v_depths[i] = sums[place, CHANNELS + channels]
        if absgrad:
            v_absolute[i, 0] = sums[place, CHANNELS + channels + with_depth] * np.float32(1.0 / LOG2_E)
            v_absolute[i, 1] = sums[place, CHANNELS + channels + with_depth + 1] * np.float32(1.0 / LOG2_E)
