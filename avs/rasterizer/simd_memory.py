"""Vectors of sixteen float32 numbers between registers and memory: loads, stores, sums over the lanes."""

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from avs.rasterizer.kernels import Floats, inline
from avs.rasterizer.simd import VECTOR, constant
from avs.rasterizer.simd_types import FLOATS, LANES, Part, call

_intrinsic = cast("Callable[[Callable[..., Any]], Any]", intrinsic)


def _address(context: Part, builder: Part, kind: Part, array: Part, index: Part) -> Part:
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), FLOATS.as_pointer())


def _row_addresses(context: Part, builder: Part, count: int, kind: Part, array: Part, index: Part) -> list[Part]:
    offsets = [builder.add(index, ir.Constant(index.type, row * LANES)) for row in range(count)]
    return [_address(context, builder, kind, array, offset) for offset in offsets]


@_intrinsic
def load(typingctx: Part, array: Part, index: Part) -> Part:
    """Return sixteen consecutive elements of a one-dimensional float32 array."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        address = _address(context, builder, signature.args[0], *arguments)
        return builder.load(address, align=4, typ=FLOATS)

    return VECTOR(array, types.intp), codegen


@_intrinsic
def store(typingctx: Part, array: Part, index: Part, value: Part) -> Part:
    """Set sixteen consecutive elements of a one-dimensional float32 array."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        address = _address(context, builder, signature.args[0], *arguments[:2])
        builder.store(arguments[2], address, align=4)
        return context.get_dummy_value()

    return types.void(array, types.intp, VECTOR), codegen


@_intrinsic
def load_rows(typingctx: Part, array: Part, index: Part, count: Part) -> Part:
    """Return a tuple of ``count``, a constant, vectors that follow one another in a one-dimensional float32 array."""
    if not isinstance(count, types.IntegerLiteral):
        return None
    number = count.literal_value
    result = types.UniTuple(VECTOR, number)  # type: ignore[no-untyped-call]

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        addresses = _row_addresses(context, builder, number, signature.args[0], *arguments[:2])
        rows = [builder.load(address, align=4, typ=FLOATS) for address in addresses]
        return context.make_tuple(builder, result, rows)

    return result(array, types.intp, count), codegen


@_intrinsic
def store_rows(typingctx: Part, array: Part, index: Part, values: Part) -> Part:
    """Set vectors that follow one another in a one-dimensional float32 array to the elements of a tuple."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        addresses = _row_addresses(context, builder, len(values), signature.args[0], *arguments[:2])
        for row, address in enumerate(addresses):
            builder.store(builder.extract_value(arguments[2], row), address, align=4)
        return context.get_dummy_value()

    return types.void(array, types.intp, values), codegen


@_intrinsic
def prefetch(typingctx: Part, array: Part, index: Part) -> Part:
    """Fetch an element's cache line ahead of its use."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        address = builder.gep(data, [arguments[1]])
        byte = ir.IntType(8).as_pointer()
        # to be read, to be kept in all caches, data
        hints = [ir.Constant(ir.IntType(32), hint) for hint in (0, 3, 1)]
        call(builder, "llvm.prefetch.p0", ir.VoidType(), [builder.bitcast(address, byte), *hints])
        return context.get_dummy_value()

    return types.void(array, types.intp), codegen


def _shuffle(builder: Part, a: Part, b: Part, lanes: list[int]) -> Part:
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(ir.IntType(32), len(lanes)), lanes))


def _fold_pair(builder: Part, a: Part, b: Part, group: int) -> Part:
    """Halve groups of ``group`` lanes of two vectors and return both, those of ``a`` before those of ``b``."""
    half = group // 2
    lower = [start + lane for start in range(0, 2 * LANES, group) for lane in range(half)]
    return builder.fadd(_shuffle(builder, a, b, lower), _shuffle(builder, a, b, [lane + half for lane in lower]))


@_intrinsic
def sum_lanes(typingctx: Part, vector: Part) -> Part:
    """Return the sum of the sixteen numbers, as a scalar."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        vector = arguments[0]
        for group in (16, 8, 4, 2):
            vector = _fold_pair(builder, vector, vector, group)
        return builder.extract_element(vector, ir.Constant(ir.IntType(32), 0))

    return types.float32(VECTOR), codegen


@_intrinsic
def add_row_sums(typingctx: Part, rows: Part, start: Part, like: Part, sums: Part, to: Part) -> Part:
    """Add to ``sums``, from place ``to`` on, the sums of consecutive rows of sixteen numbers in ``rows``.

    As many rows as the tuple ``like`` is long; a multiple of sixteen elements of ``sums`` is written, with 0 added to
    the superfluous ones. Sixteen rows are folded together, which takes a third of the instructions that folding each
    would.
    """
    count = len(like)

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        addresses = _row_addresses(context, builder, count, signature.args[0], *arguments[:2])
        targets = _row_addresses(context, builder, -(-count // LANES), signature.args[3], *arguments[3:])
        for first in range(0, count, LANES):
            here = range(first, min(first + LANES, count))
            vectors = [builder.load(addresses[row], align=4, typ=FLOATS) for row in here]
            group = LANES
            while group > 1:
                pairs = [
                    (vectors[k], (vectors[k + 1 : k + 2] or [constant(0.0)])[0]) for k in range(0, len(vectors), 2)
                ]
                vectors = [_fold_pair(builder, a, b, group) for a, b in pairs]
                group //= 2
            target = targets[first // LANES]
            total = builder.fadd(builder.load(target, align=4, typ=FLOATS), vectors[0])
            builder.store(total, target, align=4)
        return context.get_dummy_value()

    return types.void(rows, types.intp, like, sums, types.intp), codegen


@inline
def aligned_empty(count: int) -> Floats:
    """Return ``count`` float32 elements of memory that begin at a cache line, so that no vector in it straddles two."""
    room = np.empty(count + LANES, np.float32)
    start = (-room.ctypes.data % 64) // 4
    return room[start : start + count]


@inline
def aligned_full(count: int, value: float) -> Floats:
    """Return :func:`aligned_empty` filled with ``value``."""
    array: Floats = aligned_empty(count)
    for k in range(count):
        array[k] = np.float32(value)
    return array
