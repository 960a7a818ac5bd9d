"""Kernel of the blending weights of the Gaussians in front: sums over the pixels that much light still reaches."""

import numpy as np

from avs.rasterizer.blending import (
    ALPHA_MAX,
    BLOCKS,
    PIXELS,
    TRANSMITTANCE_MIN,
    pixel_centres,
)  # fmt: skip
from avs.rasterizer.kernels import Floats, Integers, Number, inline, kernel
from avs.rasterizer.simd import LANES, any_of, broadcast, exp2, fma, minimum, where
from avs.rasterizer.simd_memory import aligned_empty, load, store, sum_lanes
from avs.rasterizer.splat_records import LOG2_ALPHA_MIN, LOG_OPACITY, XX, XY, YY, X, Y
from avs.rasterizer.tiles import TILE


@kernel
def front_sums(
    records: Floats, entries: Integers, offsets: Integers, image: Floats, least: Number,
) -> tuple[Floats, Integers]:  # fmt: skip
    """Return, per record, the sum of weight times image over the pixels where it is in front, and their number.

    In front: the transmittance before the record is above ``least``. ``entries`` and ``offsets`` are what
    :func:`~avs.rasterizer.blending.blend` returned for the records.
    """
    height, width = image.shape
    columns, rows = (width + TILE - 1) // TILE, (height + TILE - 1) // TILE
    sums, counts = np.zeros(len(records)), np.zeros(len(records), np.int64)
    # transmittances and pixels of a tile
    scratch = aligned_empty(2 * PIXELS)
    column, row = pixel_centres()
    for tile in range(columns * rows):
        x, y = TILE * (tile % columns), TILE * (tile // columns)
        for p in range(PIXELS):
            inside = x + p % TILE < width and y + p // TILE < height
            scratch[p] = np.float32(1.0) if inside else np.float32(-1.0)
            scratch[PIXELS + p] = image[y + p // TILE, x + p % TILE] if inside else np.float32(0.0)
        live = True
        for chunk in range(len(offsets)):
            if live:
                live = _sums_of_tile(
                    records, entries, offsets[chunk, tile], offsets[chunk, tile + 1],
                    column + np.float32(x), row + np.float32(y), least, scratch, sums, counts,
                )  # fmt: skip
    return sums, counts


@inline
def _sums_of_tile(
    records: Floats, entries: Integers, start: int, end: int, x: Number, y: Number, least: Number, scratch: Floats,
    sums: Floats, counts: Integers,
) -> bool:  # fmt: skip
    """Add a list's sums, by the forward pass's decisions. Return whether a pixel has light above ``least``."""
    flat = records.reshape(-1)
    for e in range(start, end):
        place = entries[e]
        at = place * records.shape[1]
        dx = x - flat[at + X]
        quadratic = (flat[at + XX] * dx) * dx
        mixed = flat[at + XY] * dx
        total, count = broadcast(0.0), broadcast(0.0)
        live = False
        blends = False
        for block in range(BLOCKS):
            here = block * LANES
            dy = y - (flat[at + Y] - np.float32(2 * block))
            power = fma(dy, fma(dy, flat[at + YY], mixed), quadratic)
            exponent = power + flat[at + LOG_OPACITY]
            light = load(scratch, here)
            touched = (exponent >= LOG2_ALPHA_MIN) & (power <= 0.0) & (light > least)
            if any_of(touched):
                alpha = minimum(exp2(exponent), ALPHA_MAX)
                onward = light * (1.0 - alpha)
                blended = touched & (onward > TRANSMITTANCE_MIN)
                total = fma(where(blended, alpha * light, 0.0), load(scratch, PIXELS + here), total)
                count = count + where(blended, 1.0, 0.0)
                # a pixel that stops has no light any more
                light = where(touched, where(blended, onward, -1.0), light)
                store(scratch, here, light)
                blends = True
            live |= any_of(light > least)
        if blends:
            sums[place] += sum_lanes(total)
            counts[place] += np.int64(sum_lanes(count))
        if not live:
            return False
    return True
