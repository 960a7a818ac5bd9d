"""Whether and how a Gaussian is blended into sixteen pixels: the decision that every pass over a tile takes.

The passes after the forward one (gradients, Fisher moments, variances, weights) recompute the opacities and must find
the same Gaussians blended and the same pixels stopped. They call the very functions that the forward pass calls.

A tile's 64 pixels are four blocks of sixteen (two rows of eight). Their transmittances lie side by side in memory; that
of a pixel that has stopped, or lies outside the image, is negative.
"""

import numpy as np

from avs.rasterizer.constants import ALPHA_MAX, TRANSMITTANCE_MIN
from avs.rasterizer.kernels import Floats, Number, inline
from avs.rasterizer.simd import any_of, exp2, fma, minimum, where
from avs.rasterizer.simd_memory import load
from avs.rasterizer.simd_types import LANES
from avs.rasterizer.splat_records import LOG2_ALPHA_MIN, LOG_OPACITY, XX, XY, YY, X, Y
from avs.rasterizer.tiles import TILE

PIXELS = TILE * TILE
BLOCKS = PIXELS // LANES
# How many entries of a list ahead a record is fetched into the cache.
PREFETCH = 4


@inline
def pixel_centres() -> tuple[Number, Number]:
    """Return the columns and rows of the centres of a tile's first sixteen pixels, from the tile's corner."""
    numbers = np.empty(2 * LANES, np.float32)
    for lane in range(LANES):
        numbers[lane] = np.float32(lane % TILE) + np.float32(0.5)
        numbers[LANES + lane] = np.float32(lane // TILE) + np.float32(0.5)
    return load(numbers, 0), load(numbers, LANES)


@inline
def start_tile(transmittance: Floats, base: int, x: int, y: int, width: int, height: int) -> int:
    """Set the 64 transmittances from ``base`` on: 1, or -1 outside the image. Return the live blocks.

    The tile's first pixel is (x, y), the image ``width`` by ``height`` pixels.
    """
    for p in range(PIXELS):
        inside = x + p % TILE < width and y + p // TILE < height
        transmittance[base + p] = np.float32(1.0) if inside else np.float32(-1.0)
    live: int = live_blocks(transmittance, base)
    return live


@inline
def live_blocks(transmittance: Floats, base: int) -> int:
    """Return a bit for each of a tile's four blocks that has a pixel which has not stopped."""
    live = 0
    for block in range(BLOCKS):
        if any_of(load(transmittance, base + block * LANES) > 0.0):
            live |= 1 << block
    return live


@inline
def column_terms(records: Floats, at: int, x: Number) -> tuple[Number, Number, Number, Number]:
    """Return what of a record's exponent is the same in every row of pixels.

    Args:
        records: all records, flat.
        at: where the Gaussian's begins.
        x: columns of the pixels' centres.

    Returns:
        dx, the quadratic form's part in dx^2, its factor of dy, and the logarithm of the opacity.
    """
    dx = x - records[at + X]
    return dx, (records[at + XX] * dx) * dx, records[at + XY] * dx, records[at + LOG_OPACITY]


@inline
def touch(
    records: Floats, at: int, y: Number, block: int, quadratic: Number, mixed: Number, log_opacity: Number,
    light: Number, least: float,
) -> tuple[Number, Number, Number]:  # fmt: skip
    """Return which pixels of a block a Gaussian touches: opacity not below the threshold, light above ``least``.

    Args:
        records: all records, flat.
        at: where the Gaussian's begins.
        y: rows of the centres of the tile's first block.
        block: number of the block.
        quadratic: from ``column_terms``.
        mixed: from ``column_terms``.
        log_opacity: from ``column_terms``.
        light: the block's transmittances.
        least: 0 for all pixels that have not stopped.

    Returns:
        dy, the logarithm of the opacity to base 2, and the mask.
    """
    dy = y - (records[at + Y] - np.float32(2 * block))
    power = fma(dy, fma(dy, records[at + YY], mixed), quadratic)
    exponent = power + log_opacity
    # rounding may make the quadratic form of a long, thin Gaussian positive; gsplat skips such pixels, too
    return dy, exponent, (exponent >= LOG2_ALPHA_MIN) & (power <= 0.0) & (light > least)


# Without an array among its arguments: numba would count references to it in the innermost loop.
@inline
def attenuate(exponent: Number, touched: Number, light: Number) -> tuple[Number, Number, Number, Number, Number, bool]:
    """Blend a Gaussian into the pixels that it touches.

    Args:
        exponent: logarithm of the opacity to base 2.
        touched: mask of the pixels.
        light: their transmittances.

    Returns:
        The opacity before it is held, and as it is blended; both may be anything where nothing is blended, see
        ``exp2``. Then the light behind the Gaussian, the mask of the pixels that it is blended into, the new
        transmittances, and whether a pixel stops.
    """
    unclamped = exp2(exponent)
    alpha = minimum(unclamped, ALPHA_MAX)
    onward = light * (1.0 - alpha)
    blended = touched & (onward > TRANSMITTANCE_MIN)
    stops = touched & (onward <= TRANSMITTANCE_MIN)
    left = where(blended, onward, where(touched, -light, light))
    return unclamped, alpha, onward, blended, left, any_of(stops)
