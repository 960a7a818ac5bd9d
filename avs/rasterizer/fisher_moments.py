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
from avs.rasterizer.simd import any_of, broadcast, fma, where
from avs.rasterizer.simd_memory import add_row_sums, aligned_empty, aligned_full, load, prefetch, store, store_rows
from avs.rasterizer.simd_types import LANES
from avs.rasterizer.splat_records import COLOR
from avs.rasterizer.tiles import TILE

# Columns of the moments: Gij that of g^2 dx^i u^j, Wij that of g w dx^i u^j, WEIGHT that of w^2.
G00, G01, G02, G03, G04, G10, G11, G12, G13, G20, G21, G22, G30, G31, G40 = range(15)
W00, W01, W02, W10, W11, W20, WEIGHT = range(15, 22)
MOMENTS = 22
_LIKE = (0,) * MOMENTS
_WIDTH = 32

# Layout of a tile's scratch memory: transmittance and remaining sum of its pixels, one row for each of the moments.
_LIGHT, _REST, _SUMS, _SCRATCH = 0, PIXELS, 2 * PIXELS, 2 * PIXELS + MOMENTS * LANES


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
    scratch = aligned_empty(_SCRATCH)
    column, row = pixel_centres()
    for tile in range(columns * rows):
        x, y = TILE * (tile % columns), TILE * (tile // columns)
        live = start_tile(scratch, _LIGHT, x, y, width, height)
        for p in range(PIXELS):
            blended = np.float32(1.0) - abs(transmittance[tile * PIXELS + p])
            scratch[_REST + p] = pixels[tile * PIXELS + p] - background * blended
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
        dx, quadratic, mixed, log_opacity = column_terms(flat, at, x)
        leaning = shears[place] * dx
        inner = flat[at + COLOR] - background
        stopped = False
        blends = False
        s0 = s1 = s2 = s3 = s4 = c0 = c1 = c2 = weights = broadcast(0.0)
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
                rest = load(scratch, _REST + here) - weight * inner
                store(scratch, _REST + here, rest)
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
            store_rows(scratch, _SUMS + G00 * LANES, (s0, s1, s2, s3, s4))
            s0, s1, s2, s3 = s0 * dx, s1 * dx, s2 * dx, s3 * dx
            store_rows(scratch, _SUMS + G10 * LANES, (s0, s1, s2, s3))
            s0, s1, s2 = s0 * dx, s1 * dx, s2 * dx
            store_rows(scratch, _SUMS + G20 * LANES, (s0, s1, s2))
            s0, s1 = s0 * dx, s1 * dx
            store_rows(scratch, _SUMS + G30 * LANES, (s0, s1))
            store(scratch, _SUMS + G40 * LANES, s0 * dx)
            store_rows(scratch, _SUMS + W00 * LANES, (c0, c1, c2))
            c0, c1 = c0 * dx, c1 * dx
            store_rows(scratch, _SUMS + W10 * LANES, (c0, c1))
            store(scratch, _SUMS + W20 * LANES, c0 * dx)
            store(scratch, _SUMS + WEIGHT * LANES, weights)
            add_row_sums(scratch, _SUMS, _LIKE, flat_moments, place * _WIDTH)
        if stopped:
            live = live_blocks(scratch, _LIGHT)
            if live == 0:
                break
    return live
