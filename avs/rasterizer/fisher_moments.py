"""Second moments over pixels, from which the diagonal Fisher information follows.

A pixel's channel sum depends on a Gaussian through seven numbers: centre (2), conic (3), opacity (1), colour (1). With
g = alpha dL/d alpha as in the backward pass and (dx, dy) the pixel relative to the centre, its derivatives by the first
six are g times linear combinations of 1, dx, dy, dx^2, dx dy and dy^2, and the weight w = alpha T by the last. What is
summed over pixels for each Gaussian are therefore moments of fourth degree, from which the sum of squares of any linear
combination follows exactly; ``fisher_chain.py`` does that, once per Gaussian rather than once per pixel.

The moments are those of dx and u = dy + t dx, with t = B / C for a conic (A, B, C): in these coordinates the ellipse is
upright, C u^2 + (A - B^2 / C) dx^2. In dx and dy those of a long, thin, oblique Gaussian nearly depend on one another,
and the derivative by its short axis would be a small difference of large sums. There are 22 sums: g^2 dx^i u^j
(i + j <= 4), g w dx^i u^j (i + j <= 2) and w^2.
"""

import numpy as np

from avs.rasterizer.blending import (
    ALPHA_MAX,
    BLOCKS,
    PIXELS,
    PREFETCH,
    TRANSMITTANCE_MIN,
    live_blocks,
    pixel_centres,
)  # fmt: skip
from avs.rasterizer.kernels import Floats, Integers, Number, inline, kernel
from avs.rasterizer.simd import LANES, any_of, broadcast, exp2, fma, minimum, where
from avs.rasterizer.simd_memory import add_row_sums, aligned_empty, aligned_full, load, prefetch, store
from avs.rasterizer.splat_records import COLOR, LOG2_ALPHA_MIN, LOG_OPACITY, XX, XY, YY, X, Y
from avs.rasterizer.tiles import TILE

# Columns of the moments: g^2 dx^i u^j in the order (0, 0) ... (0, 4), (1, 0) ... (1, 3), ... (4, 0); then g w dx^i u^j
# in the order (0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (2, 0); then w^2.
WEIGHT = 21
MOMENTS = 22
_LIKE = (0,) * MOMENTS
_WIDTH = 32


@kernel
def second_moments(
    records: Floats, shears: Floats, entries: Integers, offsets: Integers, transmittance: Floats, pixels: Floats,
    background: Number, width: int, height: int,
) -> Floats:  # fmt: skip
    """Return the moments ``[M, 32]`` of each record, whose single channel is the sum of the colour's; 22 columns count.

    ``shears [M]`` are the records' t. The next four arguments are what
    :func:`~avs.rasterizer.blending.blend` returned; ``background`` is the sum of its channels.
    """
    columns, rows = (width + TILE - 1) // TILE, (height + TILE - 1) // TILE
    moments: Floats = aligned_full(len(records) * _WIDTH, 0.0).reshape((len(records), _WIDTH))
    scratch = aligned_empty(2 * PIXELS + len(_LIKE) * LANES)
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
                    records, shears, entries, offsets[chunk, tile], offsets[chunk, tile + 1],
                    column + np.float32(x), row + np.float32(y), background, live, scratch, moments,
                )  # fmt: skip
    return moments


# Long because the sums over a tile are local vectors, which stay in registers: an inlined function cannot add to
# those of its caller.
@inline
def _moments_of_tile(
    records: Floats, shears: Floats, entries: Integers, start: int, end: int, x: Number, y: Number,
    background: Number, live: int, scratch: Floats, moments: Floats,
) -> int:  # fmt: skip
    """Add a list's moments; the same decisions as in the forward pass. Return the live blocks."""
    flat, flat_moments = records.reshape(-1), moments.reshape(-1)
    for e in range(start, end):
        ahead = entries[min(e + PREFETCH, end - 1)]
        prefetch(flat, ahead * records.shape[1])
        prefetch(flat_moments, ahead * _WIDTH)
        place = entries[e]
        at = place * records.shape[1]
        dx = x - flat[at + X]
        quadratic = (flat[at + XX] * dx) * dx
        mixed = flat[at + XY] * dx
        leaning = shears[place] * dx
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
                u = dy + leaning
                square, cross, u2 = g * g, g * weight, u * u
                s0 = s0 + square
                s1 = fma(square, u, s1)
                s2 = fma(square, u2, s2)
                s3 = fma(square * u, u2, s3)
                s4 = fma(square * u2, u2, s4)
                c0 = c0 + cross
                c1 = fma(cross, u, c1)
                c2 = fma(cross, u2, c2)
                weights = fma(weight, weight, weights)
        if blends:
            rows = 2 * PIXELS
            store(scratch, rows, s0)
            store(scratch, rows + LANES, s1)
            store(scratch, rows + 2 * LANES, s2)
            store(scratch, rows + 3 * LANES, s3)
            store(scratch, rows + 4 * LANES, s4)
            s0, s1, s2, s3 = s0 * dx, s1 * dx, s2 * dx, s3 * dx
            store(scratch, rows + 5 * LANES, s0)
            store(scratch, rows + 6 * LANES, s1)
            store(scratch, rows + 7 * LANES, s2)
            store(scratch, rows + 8 * LANES, s3)
            s0, s1, s2 = s0 * dx, s1 * dx, s2 * dx
            store(scratch, rows + 9 * LANES, s0)
            store(scratch, rows + 10 * LANES, s1)
            store(scratch, rows + 11 * LANES, s2)
            s0, s1 = s0 * dx, s1 * dx
            store(scratch, rows + 12 * LANES, s0)
            store(scratch, rows + 13 * LANES, s1)
            store(scratch, rows + 14 * LANES, s0 * dx)
            store(scratch, rows + 15 * LANES, c0)
            store(scratch, rows + 16 * LANES, c1)
            store(scratch, rows + 17 * LANES, c2)
            c0, c1 = c0 * dx, c1 * dx
            store(scratch, rows + 18 * LANES, c0)
            store(scratch, rows + 19 * LANES, c1)
            store(scratch, rows + 20 * LANES, c0 * dx)
            store(scratch, rows + WEIGHT * LANES, weights)
            add_row_sums(scratch, rows, _LIKE, flat_moments, place * _WIDTH)
        if stopped:
            live = live_blocks(scratch, 0)
            if live == 0:
                break
    return live
