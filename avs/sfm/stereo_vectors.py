"""Bilinear samples of a picture at sixteen places at once, for the kernels of stereo.

The four pixels around a place lie packed in one 32-bit number, so that a sample is one load: sixteen scattered loads,
not sixty-four, which on processors with AVX-512 or AVX2 are one instruction.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from avs.rasterizer.simd import VECTOR
from avs.rasterizer.simd_masks import bits
from avs.rasterizer.simd_types import FLOATS, INT, INTS, LANES, Part, call

_intrinsic = cast("Callable[[Callable[..., Any]], Any]", intrinsic)

EDGE = 1.001
"""Coordinates lie in ``0 .. size - EDGE``: the pixel to the right and the one below must be there."""

BORDER = 14
"""Pixels around a picture that is looked at, so that windows at its edge need no cases."""


def packed(grey: npt.NDArray[np.uint8]) -> npt.NDArray[np.int32]:
    """Return a picture ``[h, w]`` with each pixel's right, lower and lower right neighbour in its upper bytes.

    Returns:
        ``[(h + 2 BORDER) * (w + 2 BORDER)]`` int32; in the border the pixels of the edge repeat.
    """
    wide = np.pad(grey, (BORDER, BORDER + 1), mode="edge").astype(np.uint32)
    joined = wide[:-1, :-1] | wide[:-1, 1:] << 8 | wide[1:, :-1] << 16 | wide[1:, 1:] << 24
    return np.ascontiguousarray(joined).view(np.int32).reshape(-1)


def bordered(values: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return the numbers of a map ``[h, w]``, in a border of zeros, for ``nearest``."""
    return np.pad(values, BORDER).reshape(-1)


def _all(value: int) -> ir.Constant:
    return ir.Constant(INTS, [value] * LANES)


def _places(builder: Part, wide: Part, columns: Part, rows: Part) -> Part:
    """Emit ``rows * wide + columns``."""
    narrow = builder.trunc(wide, INT)
    one = builder.insert_element(ir.Constant(INTS, ir.Undefined), narrow, ir.Constant(INT, 0))
    stride = builder.shuffle_vector(one, ir.Constant(INTS, ir.Undefined), _all(0))
    return builder.add(builder.mul(rows, stride), columns)


def _gathered(context: Part, builder: Part, kind: Part, element: Part, array: Part, start: Part, places: Part) -> Part:
    """Emit the load of sixteen elements of a one-dimensional array, counted from ``start`` on, as one vector.

    Where the machine has no instruction for it LLVM emits sixteen loads.
    """
    data = builder.gep(context.make_array(kind)(context, builder, array).data, [start], source_etype=element)
    # llvmlite has no method for the address of each lane
    addresses = ir.instructions.GEPInstr(builder.block, data, [places], False, "", source_etype=element)
    addresses.type = ir.VectorType(ir.PointerType(), LANES)
    builder._insert(addresses)
    result = ir.VectorType(element, LANES)
    name = f"llvm.masked.gather.v{LANES}{'f' if element == ir.FloatType() else 'i'}32.v{LANES}p0"
    every = ir.Constant(ir.VectorType(ir.IntType(1), LANES), [1] * LANES)
    align = ir.Constant(INT, 4)
    return call(builder, name, result, [addresses, align, every, ir.Constant(result, ir.Undefined)])


@_intrinsic
def nearest(typingctx: Part, values: Part, start: Part, width: Part, x: Part, y: Part) -> Part:
    """Return the numbers of a map at the pixels nearest to sixteen places; arguments are those of ``sample``."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        array, start, wide, x, y = arguments
        half = ir.Constant(FLOATS, [0.5] * LANES)
        columns, rows = (builder.fptosi(builder.fadd(place, half), INTS) for place in (x, y))
        places = _places(builder, wide, columns, rows)
        return _gathered(context, builder, signature.args[0], ir.FloatType(), array, start, places)

    return VECTOR(values, types.int64, types.int64, VECTOR, VECTOR), codegen


@_intrinsic
def sample(typingctx: Part, picture: Part, start: Part, width: Part, x: Part, y: Part) -> Part:
    """Return the grey values in 0..255 at sixteen places between the centres of pixels.

    Args:
        typingctx: numba's.
        picture: of ``packed``, or several of them one after another.
        start: where the picture begins in it, int64.
        width: of the picture in pixels with its border, int64.
        x: columns, 0 at the centre of the leftmost pixel of the border, in ``0 .. width - EDGE``.
        y: rows, likewise.
    """

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        array, start, wide, x, y = arguments
        columns, rows = builder.fptosi(x, INTS), builder.fptosi(y, INTS)
        across, down = (
            builder.fsub(place, builder.sitofp(whole, FLOATS)) for place, whole in ((x, columns), (y, rows))
        )
        places = _places(builder, wide, columns, rows)
        quads = _gathered(context, builder, signature.args[0], INT, array, start, places)
        corners = [
            builder.sitofp(builder.and_(builder.lshr(quads, _all(shift)), _all(255)), FLOATS)
            for shift in (0, 8, 16, 24)
        ]

        def mixed(a: Part, b: Part, share: Part) -> Part:
            return call(builder, "llvm.fmuladd.v16f32", FLOATS, [builder.fsub(b, a), share, a])

        return mixed(mixed(corners[0], corners[1], across), mixed(corners[2], corners[3], across), down)

    return VECTOR(picture, types.int64, types.int64, VECTOR, VECTOR), codegen


@_intrinsic
def inverse_root(typingctx: Part, vector: Part) -> Part:
    """Return one through the square root of sixteen normal numbers greater than 0, to 5 parts in a million.

    A guess by halving the exponent and two of Newton's steps: a sixth of the time of a root and a division.
    """

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        vector = arguments[0]
        halved = builder.lshr(builder.bitcast(vector, INTS), _all(1))
        guess = builder.bitcast(builder.sub(_all(0x5F3759DF), halved), FLOATS)
        minus_half = builder.fmul(vector, ir.Constant(FLOATS, [-0.5] * LANES))
        for _ in range(2):
            square = builder.fmul(guess, guess)
            factor = call(
                builder, "llvm.fmuladd.v16f32", FLOATS, [minus_half, square, ir.Constant(FLOATS, [1.5] * LANES)]
            )
            guess = builder.fmul(guess, factor)
        return guess

    return VECTOR(VECTOR), codegen


@_intrinsic
def count_of(typingctx: Part, mask: Part) -> Part:
    """Return how many of sixteen truth values hold."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        found = call(builder, "llvm.ctpop.i32", INT, [bits(builder, arguments[0])])
        return builder.zext(found, ir.IntType(64))

    return types.int64(mask), codegen


@_intrinsic
def least_of(typingctx: Part, vector: Part) -> Part:
    """Return the least of sixteen numbers, none of them NaN, as a scalar."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        vector = arguments[0]
        for half in (8, 4, 2, 1):
            lanes = [*range(half, 2 * half), *range(half, LANES), *range(half)][:LANES]
            other = builder.shuffle_vector(vector, vector, ir.Constant(INTS, lanes))
            vector = builder.select(builder.fcmp_ordered("<", other, vector), other, vector)
        return builder.extract_element(vector, ir.Constant(INT, 0))

    return types.float32(VECTOR), codegen
