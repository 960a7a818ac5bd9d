"""Blending weights of the Gaussians in front: sums over the pixels where much light still reaches them."""

from __future__ import annotations

import numpy as np
from torch import Tensor

from avs.rasterizer.blended_view import blend_view, project_view
from avs.rasterizer.blending_decision import (
    BLOCKS,
    PIXELS,
    attenuate,
    column_terms,
    pixel_centres,
    start_tile,
    touch,
)
from avs.rasterizer.kernels import Floats, Integers, Number, inline, kernel
from avs.rasterizer.simd import any_of, broadcast, fma, where
from avs.rasterizer.simd_memory import aligned_empty, load, store, sum_lanes
from avs.rasterizer.simd_types import LANES
from avs.rasterizer.tiles import TILE

# Layout of a tile's scratch memory: transmittance and value of its pixels.
_LIGHT, _IMAGE, _SCRATCH = 0, PIXELS, 2 * PIXELS


def weights_in_front(
    means: Tensor,
    quats: Tensor,
    scales: Tensor,
    opacities: Tensor,
    viewmat: Tensor,
    intrinsics: Tensor,
    image: Floats,
    transmittance: float,
) -> tuple[Floats, Integers]:
    """Return, per Gaussian, the sum of weight times ``image`` over the pixels where it lies in front, and their number.

    It lies in front where the transmittance that reaches it is above ``transmittance``.

    Args:
        means: centres ``[N, 3]`` float32 on the CPU, as all other tensors.
        quats: rotations ``[N, 4]``, w first.
        scales: standard deviations ``[N, 3]``.
        opacities: ``[N]`` in 0..1.
        viewmat: world-to-camera matrix ``[4, 4]``.
        intrinsics: in pixels ``[3, 3]``.
        image: ``[height, width]``, of the size that is rendered.
        transmittance: 0 counts every pixel that a Gaussian is blended into.

    Returns:
        Sums ``[N]`` float64 and numbers of pixels ``[N]`` int64.
    """
    height, width = image.shape
    view, _ = project_view(means, quats, scales, opacities, viewmat, intrinsics, width, height)
    blended = blend_view(view, np.empty((len(means), 0), np.float32), width, height)
    sums, pixels = np.zeros(len(means)), np.zeros(len(means), np.int64)
    sums[blended.order], pixels[blended.order] = _front_sums(
        blended.records, blended.entries, blended.offsets, np.ascontiguousarray(image, dtype=np.float32),
        np.float32(transmittance),
    )  # fmt: skip
    return sums, pixels


@kernel
def _front_sums(
    records: Floats, entries: Integers, offsets: Integers, image: Floats, least: Number,
) -> tuple[Floats, Integers]:  # fmt: skip
    """Return, per record, the sum of weight times image over the pixels where it is in front, and their number.

    ``entries`` and ``offsets`` are what
    :func:`~avs.rasterizer.blending.blend` returned for the records.
    """
    height, width = image.shape
    columns, rows = (width + TILE - 1) // TILE, (height + TILE - 1) // TILE
    sums, counts = np.zeros(len(records)), np.zeros(len(records), np.int64)
    scratch = aligned_empty(_SCRATCH)
    column, row = pixel_centres()
    for tile in range(columns * rows):
        x, y = TILE * (tile % columns), TILE * (tile // columns)
        start_tile(scratch, _LIGHT, x, y, width, height)
        for p in range(PIXELS):
            inside = scratch[_LIGHT + p] > 0
            scratch[_IMAGE + p] = image[y + p // TILE, x + p % TILE] if inside else np.float32(0.0)
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
        _, quadratic, mixed, log_opacity = column_terms(flat, at, x)
        total, count = broadcast(0.0), broadcast(0.0)
        live = False
        blends = False
        for block in range(BLOCKS):
            here = block * LANES
            light = load(scratch, _LIGHT + here)
            _, exponent, touched = touch(flat, at, y, block, quadratic, mixed, log_opacity, light, least)
            if any_of(touched):
                _, alpha, _, blended, left, _ = attenuate(exponent, touched, light)
                total = fma(where(blended, alpha * light, 0.0), load(scratch, _IMAGE + here), total)
                store(scratch, _LIGHT + here, left)
                count = count + where(blended, 1.0, 0.0)
                blends = True
                light = left
            live |= any_of(light > least)
        if blends:
            sums[place] += sum_lanes(total)
            counts[place] += np.int64(sum_lanes(count))
        if not live:
            return False
    return True
