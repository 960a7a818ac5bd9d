"""Front-to-back alpha blending of projected Gaussians over 8x8 tiles, forward pass.

For each block of sixteen pixels and each Gaussian of the tile's list, the exponent of the opacity is compared with its
threshold first, so that all else is skipped where none of the sixteen is touched.
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
from avs.rasterizer.kernels import Floats, Integers, Number, inline, kernel
from avs.rasterizer.simd import any_of, fma, where
from avs.rasterizer.simd_memory import aligned_full, load, prefetch, store
from avs.rasterizer.simd_types import LANES
from avs.rasterizer.splat_records import COLOR
from avs.rasterizer.tiles import TILE, grown, tile_lists


@inline
def _blend_tile(
    records: Floats, entries: Integers, start: int, end: int, x: Number, y: Number, channels: tuple[int, ...],
    squares: tuple[int, ...], share: float, live: int, transmittance: Floats, base: int, pixels: Floats,
) -> int:  # fmt: skip
    """Blend a list into a tile; ``x`` and ``y`` are the pixel centres of its first block. Return the live blocks."""
    flat = records.reshape(-1)
    width = records.shape[1]
    planes = len(channels) + len(squares)
    for e in range(start, end):
        prefetch(flat, entries[min(e + PREFETCH, end - 1)] * width)
        at = entries[e] * width
        _, quadratic, mixed, log_opacity = column_terms(flat, at, x)
        stopped = False
        for block in range(BLOCKS):
            if not live & (1 << block):
                continue
            here = base + block * LANES
            light = load(transmittance, here)
            _, exponent, touched = touch(flat, at, y, block, quadratic, mixed, log_opacity, light, 0.0)
            if any_of(touched):
                _, alpha, _, blended, left, stops = attenuate(exponent, touched, light)
                store(transmittance, here, left)
                stopped |= stops
                weight = where(blended, alpha * light, 0.0)
                for c in range(len(channels)):
                    at_pixel = base * planes + c * PIXELS + block * LANES
                    store(pixels, at_pixel, fma(weight, flat[at + COLOR + c], load(pixels, at_pixel)))
                for c in range(len(squares)):
                    at_pixel = base * planes + (len(channels) + c) * PIXELS + block * LANES
                    # where nothing is blended alpha may be anything, see exp2
                    own = where(blended, weight * (1.0 - share * alpha), 0.0)
                    value = flat[at + COLOR + len(channels) + c]
                    store(pixels, at_pixel, fma(own * own, value, load(pixels, at_pixel)))
        if stopped:
            live = live_blocks(transmittance, base)
            if live == 0:
                break
    return live


@kernel
def blend(
    records: Floats, channels: tuple[int, ...], squares: tuple[int, ...], share: float, width: int, height: int,
) -> tuple[Floats, Floats, Integers, Integers]:  # fmt: skip
    """Render one camera.

    The Gaussians are taken in chunks from near to far, and tiles whose pixels have all stopped get no further entries:
    in a scene with occlusion most of the lists are never built.

    Args:
        records: from :func:`~avs.rasterizer.splat_records.pack_records`.
        channels: a tuple of as many numbers as there are channels; its length is known when the kernel is compiled.
        squares: the same for the channels after those, which are blended with squared weights.
        share: the weight that is squared is alpha T (1 - share alpha), T being the transmittance in front: 0 for the
            weight of the other channels, 1 for one with the light behind the Gaussian in the place of T.
        width: image width in pixels.
        height: image height in pixels.

    Returns:
        Transmittances ``[tiles * 64]`` (negative where a pixel stopped; meaningless outside the image), blended
        channels ``[tiles * (channels + squares) * 64]``, tile lists and their offsets ``[chunks, tiles + 1]``.
    """
    columns, rows = (width + TILE - 1) // TILE, (height + TILE - 1) // TILE
    tiles = columns * rows
    transmittance = aligned_full(tiles * PIXELS, 1.0)
    pixels = aligned_full(tiles * PIXELS * (len(channels) + len(squares)), 0.0)
    live = np.full(tiles, (1 << BLOCKS) - 1, np.uint8)
    for tile in range(tiles):
        x, y = TILE * (tile % columns), TILE * (tile // columns)
        if x + TILE > width or y + TILE > height:
            live[tile] = start_tile(transmittance, tile * PIXELS, x, y, width, height)
    column, row = pixel_centres()
    budget = max(32768, 8 * tiles)
    entries = np.empty(2 * budget, np.int32)
    offsets = np.empty(8 * (tiles + 1), np.int32)
    used = 0
    chunk = 0
    place = 0
    while place < len(records):
        at = chunk * (tiles + 1)
        offsets = grown(offsets, at, tiles + 1)
        before = used
        place, entries, used = tile_lists(records, place, budget, columns, rows, live, offsets, at, entries, used)
        if used == before:
            continue
        for tile in range(tiles):
            start, end = offsets[at + tile], offsets[at + tile + 1]
            if start < end:
                live[tile] = _blend_tile(
                    records, entries, start, end,
                    column + np.float32(TILE * (tile % columns)), row + np.float32(TILE * (tile // columns)),
                    channels, squares, share, live[tile], transmittance, tile * PIXELS, pixels,
                )  # fmt: skip
        chunk += 1
    return transmittance, pixels, entries[:used], offsets[: chunk * (tiles + 1)].reshape((chunk, tiles + 1))


@kernel
def to_image(
    transmittance: Floats, pixels: Floats, channels: tuple[int, ...], background: Floats, image: Floats,
    alpha: Floats,
) -> None:  # fmt: skip
    """Fill ``image [H, W, channels]``, with the background behind, and ``alpha [H, W]`` from the tiles."""
    height, width = alpha.shape
    columns = (width + TILE - 1) // TILE
    for y in range(height):
        for x in range(width):
            tile = (y // TILE) * columns + x // TILE
            p = (y % TILE) * TILE + x % TILE
            light = abs(transmittance[tile * PIXELS + p])
            alpha[y, x] = np.float32(1.0) - light
            for c in range(len(channels)):
                image[y, x, c] = pixels[(tile * len(channels) + c) * PIXELS + p] + light * background[c]
