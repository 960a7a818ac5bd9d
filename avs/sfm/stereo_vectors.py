"""Bilinear samples of a picture at sixteen places at once, for the kernels of stereo.

The four pixels around a place lie packed in one 32-bit number, so that a sample is one load: sixteen scattered loads,
not sixty-four, are what a comparison of two windows costs most for.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from avs.rasterizer.simd import FLOATS, LANES, VECTOR, Part, call

_intrinsic = cast("Callable[[Callable[..., Any]], Any]", intrinsic)
_INTS = ir.VectorType(ir.IntType(32), LANES)

EDGE = 1.001
"""Coordinates lie in ``0 .. size - EDGE``: the pixel to the right and the one below must be there."""


def packed(grey: npt.NDArray[np.uint8]) -> npt.NDArray[np.int32]:
    """Return a picture ``[h, w]`` with each pixel's right, lower and lower right neighbour in its upper bytes.

    Returns:
        ``[h * w]`` int32; at the right and lower edge the pixels repeat.
    """
    wide = np.pad(grey, ((0, 1), (0, 1)), mode="edge").astype(np.uint32)
    joined = wide[:-1, :-1] | wide[:-1, 1:] << 8 | wide[1:, :-1] << 16 | wide[1:, 1:] << 24
    return np.ascontiguousarray(joined).view(np.int32).reshape(-1)


def nearest_values(maps: list[npt.NDArray[np.float32]]) -> npt.NDArray[np.float32]:
    """Return the numbers of maps ``[h, w]`` one after another, for ``nearest``."""
    return np.concatenate([one.reshape(-1) for one in maps])


def _all(value: int) -> ir.Constant:
    return ir.Constant(_INTS, [value] * LANES)


def _places(builder: Part, wide: Part, columns: Part, rows: Part) -> Part:
    """Emit ``rows * wide + columns``."""
    narrow = builder.trunc(wide, ir.IntType(32))
    one = builder.insert_element(ir.Constant(_INTS, ir.Undefined), narrow, ir.Constant(ir.IntType(32), 0))
    stride = builder.shuffle_vector(one, ir.Constant(_INTS, ir.Undefined), _all(0))
    return builder.add(builder.mul(rows, stride), columns)


def _scattered(context: Part, builder: Part, kind: Part, vector: Part, array: Part, start: Part, places: Part) -> Part:
    """Emit the loads of sixteen elements of a one-dimensional array, counted from ``start`` on, as a ``vector``."""
    data = builder.gep(context.make_array(kind)(context, builder, array).data, [start])
    loaded = ir.Constant(vector, ir.Undefined)
    for lane in range(LANES):
        number = ir.Constant(ir.IntType(32), lane)
        place = builder.sext(builder.extract_element(places, number), ir.IntType(64))
        loaded = builder.insert_element(loaded, builder.load(builder.gep(data, [place])), number)
    return loaded


@_intrinsic
def nearest(typingctx: Part, values: Part, start: Part, width: Part, x: Part, y: Part) -> Part:
    """Return the numbers of a map at the pixels nearest to sixteen places; arguments are those of ``sample``."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        array, start, wide, x, y = arguments
        half = ir.Constant(FLOATS, [0.5] * LANES)
        columns, rows = (builder.fptosi(builder.fadd(place, half), _INTS) for place in (x, y))
        places = _places(builder, wide, columns, rows)
        return _scattered(context, builder, signature.args[0], FLOATS, array, start, places)

    return VECTOR(values, types.int64, types.int64, VECTOR, VECTOR), codegen


@_intrinsic
def sample(typingctx: Part, picture: Part, start: Part, width: Part, x: Part, y: Part) -> Part:
    """Return the grey values in 0..255 at sixteen places between the centres of pixels.

    Args:
        typingctx: numba's.
        picture: of ``packed``, or several of them one after another.
        start: where the picture begins in it, int64.
        width: of the picture in pixels, int64.
        x: columns, 0 at the centre of the leftmost pixel, in ``0 .. width - EDGE``.
        y: rows, likewise.
    """

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        array, start, wide, x, y = arguments
        columns, rows = builder.fptosi(x, _INTS), builder.fptosi(y, _INTS)
        across, down = (
            builder.fsub(place, builder.sitofp(whole, FLOATS)) for place, whole in ((x, columns), (y, rows))
        )
        places = _places(builder, wide, columns, rows)
        quads = _scattered(context, builder, signature.args[0], _INTS, array, start, places)
        corners = [
            builder.sitofp(builder.and_(builder.lshr(quads, _all(shift)), _all(255)), FLOATS)
            for shift in (0, 8, 16, 24)
        ]

        def mixed(a: Part, b: Part, share: Part) -> Part:
            return call(builder, "llvm.fmuladd.v16f32", FLOATS, [builder.fsub(b, a), share, a])

        return mixed(mixed(corners[0], corners[1], across), mixed(corners[2], corners[3], across), down)

    return VECTOR(picture, types.int64, types.int64, VECTOR, VECTOR), codegen


@_intrinsic
def least_of(typingctx: Part, vector: Part) -> Part:
    """Return the least of sixteen numbers, none of them NaN, as a scalar."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        vector = arguments[0]
        for half in (8, 4, 2, 1):
            lanes = [*range(half, 2 * half), *range(half, LANES), *range(half)][:LANES]
            other = builder.shuffle_vector(vector, vector, ir.Constant(_INTS, lanes))
            vector = builder.select(builder.fcmp_ordered("<", other, vector), other, vector)
        return builder.extract_element(vector, ir.Constant(ir.IntType(32), 0))

    return types.float32(VECTOR), codegen
