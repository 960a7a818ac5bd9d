"""Expected reduction of the rendered variance by one more view: the second pass over the blended Gaussians."""

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
from avs.rasterizer.kernels import Floats, Integers, Number, inline, kernel
from avs.rasterizer.simd import any_of, fma, where
from avs.rasterizer.simd_memory import aligned_empty, load, prefetch, store
from avs.rasterizer.simd_types import LANES
from avs.rasterizer.splat_records import COLOR
from avs.rasterizer.tiles import TILE

# Layout of a tile's scratch memory: transmittance, variance before the view, 1 where the view removes all of the
# variance, reduction so far.
_LIGHT, _PRIOR, _ALL, _GAIN, _SCRATCH = 0, PIXELS, 2 * PIXELS, 3 * PIXELS, 4 * PIXELS


@inline
def _load_tile(
    scratch: Floats, tile: int, x: int, y: int, transmittance: Floats, rendered: Floats, constant: float,
    saturated: bool, width: int, height: int,
) -> int:  # fmt: skip
    """Fill the scratch memory for a tile whose first pixel is (x, y). Return the live blocks."""
    live: int = start_tile(scratch, _LIGHT, x, y, width, height)
    for p in range(PIXELS):
        scratch[_PRIOR + p] = np.float32(constant) + rendered[tile * PIXELS + p]
        scratch[_ALL + p] = np.float32(1.0 if saturated and transmittance[tile * PIXELS + p] < 0 else 0.0)
        scratch[_GAIN + p] = np.float32(0.0)
    return live


@inline
def _reduce_tile(
    records: Floats, entries: Integers, start: int, end: int, x: Number, y: Number, share: float, weighted: bool,
    live: int, scratch: Floats,
) -> int:  # fmt: skip
    """Add a list's reductions to the tile's pixels. Return the live blocks."""
    flat = records.reshape(-1)
    width = records.shape[1]
    for e in range(start, end):
        prefetch(flat, entries[min(e + PREFETCH, end - 1)] * width)
        at = entries[e] * width
        _, quadratic, mixed, log_opacity = column_terms(flat, at, x)
        variance = flat[at + COLOR]
        stopped = False
        for block in range(BLOCKS):
            if not live & (1 << block):
                continue
            here = block * LANES
            light = load(scratch, _LIGHT + here)
            _, exponent, touched = touch(flat, at, y, block, quadratic, mixed, log_opacity, light, 0.0)
            if any_of(touched):
                _, alpha, _, blended, left, stops = attenuate(exponent, touched, light)
                store(scratch, _LIGHT + here, left)
                stopped |= stops
                # where nothing is blended alpha may be anything, see exp2
                weight = where(blended, alpha * light * (1.0 - share * alpha), 0.0)
                spread = weight * weight * variance
                part = where(spread > 0.0, spread / (load(scratch, _PRIOR + here) + spread), 0.0)
                part = where(load(scratch, _ALL + here) > 0.0, 1.0, part)
                amount = spread if weighted else where(blended, variance, 0.0)
                store(scratch, _GAIN + here, fma(amount, part, load(scratch, _GAIN + here)))
        if stopped:
            live = live_blocks(scratch, _LIGHT)
            if live == 0:
                break
    return live


@kernel
def sum_reductions(
    records: Floats, entries: Integers, offsets: Integers, transmittance: Floats, rendered: Floats, share: float,
    constant: float, weighted: bool, saturated: bool, width: int, height: int,
) -> float:  # fmt: skip
    """Return the sum over pixels of the variance before one more view less that after it.

    With s_i = w_i^2 beta_i and V = constant + sum_i s_i, a Gaussian's term beta_i - 1 / (1 / beta_i + w_i^2 / V) is
    beta_i s_i / (V + s_i), where nothing cancels. Sums over a pixel's Gaussians are in float32, over pixels in float64.

    Args:
        records: what was rendered; the variances beta are the only channel.
        entries: tile lists of ``blend``.
        offsets: their offsets.
        transmittance: of ``blend``.
        rendered: the channel that ``blend`` returned, the variances without the constant.
        share: as in ``blend``.
        constant: added to each pixel's variance.
        weighted: whether each Gaussian's variance counts times its squared weight, and the constant is part of what is
            lowered.
        saturated: whether a pixel that stopped has no variance left after the view.
        width: image width in pixels.
        height: image height in pixels.
    """
    columns, rows = (width + TILE - 1) // TILE, (height + TILE - 1) // TILE
    scratch = aligned_empty(_SCRATCH)
    column, row = pixel_centres()
    total = 0.0
    for tile in range(columns * rows):
        x, y = TILE * (tile % columns), TILE * (tile // columns)
        live = _load_tile(scratch, tile, x, y, transmittance, rendered, constant, saturated, width, height)
        for chunk in range(len(offsets)):
            start, end = offsets[chunk, tile], offsets[chunk, tile + 1]
            if start < end and live:
                live = _reduce_tile(
                    records, entries, start, end, column + np.float32(x), row + np.float32(y), share, weighted, live,
                    scratch,
                )  # fmt: skip
        for p in range(PIXELS):
            total += np.float64(scratch[_GAIN + p])
        if weighted:
            total += min(TILE, width - x) * min(TILE, height - y) * constant
    return total
