"""Sixteen float32 numbers as one value inside numba kernels.

The rasteriser's inner loops handle sixteen pixels, or sixteen Gaussians, at once. Left to LLVM's loop vectoriser, such a
loop is at the mercy of run-time alias checks, of reassociation flags and of what changed in the last release; here it is
spelled out with LLVM's vector types, which every back end lowers (AVX-512: one register, AVX2: two, NEON: four).

No operation carries a fast-math flag and products are fused only where :func:`fma` says so. The same expression thus
gives the same bits wherever it is compiled, which the backward pass relies on: it recomputes the opacities of the forward
pass and must take the same decisions.

Arithmetic operators, comparisons and ``&`` work as on numbers; a scalar operand is broadcast. :func:`fma`,
:func:`minimum`, :func:`maximum`, :func:`where` and :func:`square_root` take scalars, too, so that a formula can be
written once for one Gaussian and for sixteen.
"""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, models, overload, register_jitable, register_model

LANES = 16

_FLOAT = ir.FloatType()
_FLOATS = ir.VectorType(_FLOAT, LANES)
_INTS = ir.VectorType(ir.IntType(32), LANES)
_BITS = ir.VectorType(ir.IntType(1), LANES)


class _Vector(types.Type):  # type: ignore[misc]
    """Numba type of sixteen float32 numbers."""

    def __init__(self) -> None:
        super().__init__(name="float32x16")


class _Mask(types.Type):  # type: ignore[misc]
    """Numba type of sixteen truth values."""

    def __init__(self) -> None:
        super().__init__(name="bool_x16")


VECTOR = _Vector()
MASK = _Mask()


@register_model(_Vector)
class _VectorModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, _FLOATS)


@register_model(_Mask)
class _MaskModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, _BITS)


def _constant(value: float) -> ir.Constant:
    return ir.Constant(_FLOATS, [float(np.float32(value))] * LANES)


def _integers(value: int) -> ir.Constant:
    return ir.Constant(_INTS, [value] * LANES)


def _broadcast(builder: Any, scalar: Any) -> Any:
    one = builder.insert_element(ir.Constant(_FLOATS, ir.Undefined), scalar, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(one, ir.Constant(_FLOATS, ir.Undefined), ir.Constant(_INTS, [0] * LANES))


def _as_vector(context: Any, builder: Any, value: Any, kind: Any) -> Any:
    if isinstance(kind, _Vector):
        return value
    return _broadcast(builder, context.cast(builder, value, kind, types.float32))


def _call(builder: Any, name: str, result: Any, arguments: list[Any]) -> Any:
    signature = ir.FunctionType(result, [argument.type for argument in arguments])
    return builder.call(cgutils.get_or_insert_function(builder.module, signature, name), arguments)


def _elementwise(arity: int, result: types.Type, emit: Callable[..., Any]) -> Any:
    """Return an intrinsic of ``arity`` operands, each a vector or a scalar to be broadcast."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vectors = [_as_vector(context, builder, a, k) for a, k in zip(arguments, signature.args, strict=True)]
        return emit(builder, *vectors)

    if arity == 1:

        @intrinsic
        def one(typingctx, a):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
            return result(a), codegen

        return one
    if arity == 2:

        @intrinsic
        def two(typingctx, a, b):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
            return result(a, b), codegen

        return two

    @intrinsic
    def three(typingctx, a, b, c):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
        return result(a, b, c), codegen

    return three


def _is_vector(*kinds: Any) -> bool:
    return any(isinstance(kind, _Vector) for kind in kinds)


def _overload_operator(function: Callable[..., Any], result: types.Type, emit: Callable[..., Any]) -> None:
    two = _elementwise(2, result, emit)

    @overload(function, inline="never")
    def implementation(a, b):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
        if _is_vector(a, b):
            return lambda a, b: two(a, b)
        return None


_overload_operator(operator.add, VECTOR, lambda builder, a, b: builder.fadd(a, b))
_overload_operator(operator.sub, VECTOR, lambda builder, a, b: builder.fsub(a, b))
_overload_operator(operator.mul, VECTOR, lambda builder, a, b: builder.fmul(a, b))
_overload_operator(operator.truediv, VECTOR, lambda builder, a, b: builder.fdiv(a, b))
for _function, _sign in ((operator.gt, ">"), (operator.ge, ">="), (operator.lt, "<"), (operator.le, "<=")):
    _overload_operator(_function, MASK, lambda builder, a, b, sign=_sign: builder.fcmp_ordered(sign, a, b))


@intrinsic
def _negative(typingctx, a):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    return VECTOR(a), lambda context, builder, signature, arguments: builder.fneg(arguments[0])


@overload(operator.neg)
def _overload_negative(a):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    return (lambda a: _negative(a)) if isinstance(a, _Vector) else None


@intrinsic
def _mask_and(typingctx, a, b):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    return MASK(a, b), lambda context, builder, signature, arguments: builder.and_(*arguments)


@overload(operator.and_)
def _overload_and(a, b):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    return (lambda a, b: _mask_and(a, b)) if isinstance(a, _Mask) else None


@intrinsic
def any_of(typingctx, mask):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Return whether any of the sixteen truth values holds."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        bits = builder.bitcast(arguments[0], ir.IntType(LANES))
        return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(LANES), 0))

    return types.boolean(mask), codegen


def _address(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), _FLOATS.as_pointer())


@intrinsic
def _load(typingctx, array, index):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address = _address(context, builder, signature.args[0], *arguments)
        return builder.load(address, align=4, typ=_FLOATS)

    return VECTOR(array, types.intp), codegen


@intrinsic
def _store(typingctx, array, index, value):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address = _address(context, builder, signature.args[0], *arguments[:2])
        builder.store(arguments[2], address, align=4)
        return context.get_dummy_value()

    return types.void(array, types.intp, VECTOR), codegen


@intrinsic
def prefetch(typingctx, array, index):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Fetch an element's cache line ahead of its use."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        address = builder.gep(data, [arguments[1]])
        byte = ir.IntType(8).as_pointer()
        # to be read, to be kept in all caches, data
        hints = [ir.Constant(ir.IntType(32), hint) for hint in (0, 3, 1)]
        signature_of_prefetch = ir.FunctionType(ir.VoidType(), [byte] + [hint.type for hint in hints])
        function = cgutils.get_or_insert_function(builder.module, signature_of_prefetch, "llvm.prefetch.p0")
        builder.call(function, [builder.bitcast(address, byte), *hints])
        return context.get_dummy_value()

    return types.void(array, types.intp), codegen


@intrinsic
def lane_numbers(typingctx):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Return 0, 1, ..., 15."""
    numbers = ir.Constant(_FLOATS, [float(lane) for lane in range(LANES)])
    return VECTOR(), lambda context, builder, signature, arguments: numbers


load = _load
store = _store
broadcast = _elementwise(1, VECTOR, lambda builder, a: a)

_fma = _elementwise(3, VECTOR, lambda builder, a, b, c: _call(builder, "llvm.fmuladd.v16f32", _FLOATS, [a, b, c]))
_minimum = _elementwise(2, VECTOR, lambda builder, a, b: builder.select(builder.fcmp_ordered("<", a, b), a, b))
_maximum = _elementwise(2, VECTOR, lambda builder, a, b: builder.select(builder.fcmp_ordered(">", a, b), a, b))
_square_root = _elementwise(1, VECTOR, lambda builder, a: _call(builder, "llvm.sqrt.v16f32", _FLOATS, [a]))
_absolute = _elementwise(1, VECTOR, lambda builder, a: _call(builder, "llvm.fabs.v16f32", _FLOATS, [a]))


floor = _elementwise(1, VECTOR, lambda builder, a: _call(builder, "llvm.floor.v16f32", _FLOATS, [a]))
ceil = _elementwise(1, VECTOR, lambda builder, a: _call(builder, "llvm.ceil.v16f32", _FLOATS, [a]))


@intrinsic
def _select(typingctx, mask, a, b):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pair = [_as_vector(context, builder, x, k) for x, k in zip(arguments[1:], signature.args[1:], strict=True)]
        return builder.select(arguments[0], *pair)

    return VECTOR(mask, a, b), codegen


def fma(a: float, b: float, c: float) -> float:
    """Return ``a * b + c``, rounded once where the machine has an instruction for it."""
    return a * b + c


def minimum(a: float, b: float) -> float:
    """Return the lesser of ``a`` and ``b``; ``b`` if one is not a number."""
    return a if a < b else b


def maximum(a: float, b: float) -> float:
    """Return the greater of ``a`` and ``b``; ``b`` if one is not a number."""
    return a if a > b else b


def where(mask: bool, a: float, b: float) -> float:
    """Return ``a`` where ``mask`` holds, else ``b``; both are evaluated."""
    return a if mask else b


def square_root(a: float) -> float:
    """Return the square root of ``a``."""
    return float(np.sqrt(a))


def absolute(a: float) -> float:
    """Return ``a`` without its sign."""
    return abs(a)


@overload(fma)
def _overload_fma(a, b, c):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    if _is_vector(a, b, c):
        return lambda a, b, c: _fma(a, b, c)
    return lambda a, b, c: a * b + c


@overload(minimum)
def _overload_minimum(a, b):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    if _is_vector(a, b):
        return lambda a, b: _minimum(a, b)
    return lambda a, b: a if a < b else b


@overload(maximum)
def _overload_maximum(a, b):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    if _is_vector(a, b):
        return lambda a, b: _maximum(a, b)
    return lambda a, b: a if a > b else b


@overload(where)
def _overload_where(mask, a, b):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    if isinstance(mask, _Mask):
        return lambda mask, a, b: _select(mask, a, b)
    return lambda mask, a, b: a if mask else b


@overload(square_root)
def _overload_square_root(a):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    if _is_vector(a):
        return lambda a: _square_root(a)
    return lambda a: np.sqrt(a)


@overload(absolute)
def _overload_absolute(a):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    if _is_vector(a):
        return lambda a: _absolute(a)
    return lambda a: abs(a)


# 2^f on [-1/2, 1/2], minimax in the relative error, which is 9.2e-8 before rounding (linear programme on 2001 points).
_EXP2_COEFFICIENTS = (1.0, 0.69314700, 0.24022242, 0.055507336, 0.0096715130, 0.0013264727)
# Adding 1.5 * 2^23 rounds to the nearest integer and leaves it in the low bits of the sum.
_ROUNDING = 12582912.0


@intrinsic
def exp2(typingctx, exponent):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Return two to the power of each of sixteen numbers in -100..100."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        shifted = builder.fadd(arguments[0], _constant(_ROUNDING))
        fraction = builder.fsub(arguments[0], builder.fsub(shifted, _constant(_ROUNDING)))
        value = _constant(_EXP2_COEFFICIENTS[-1])
        for coefficient in _EXP2_COEFFICIENTS[-2::-1]:
            value = _call(builder, "llvm.fmuladd.v16f32", _FLOATS, [value, fraction, _constant(coefficient)])
        exponent_bits = builder.shl(builder.bitcast(shifted, _INTS), _integers(23))
        return builder.bitcast(builder.add(builder.bitcast(value, _INTS), exponent_bits), _FLOATS)

    return VECTOR(VECTOR), codegen


def _shuffle(builder: Any, a: Any, b: Any, lanes: list[int]) -> Any:
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(ir.IntType(32), len(lanes)), lanes))


def _fold_pair(builder: Any, a: Any, b: Any, group: int) -> Any:
    """Halve groups of ``group`` lanes of two vectors and return both, those of ``a`` before those of ``b``."""
    half = group // 2
    lower = [start + lane for start in range(0, 2 * LANES, group) for lane in range(half)]
    return builder.fadd(_shuffle(builder, a, b, lower), _shuffle(builder, a, b, [lane + half for lane in lower]))


@intrinsic
def sum_lanes(typingctx, vector):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Return the sum of the sixteen numbers, as a scalar."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector = arguments[0]
        for group in (16, 8, 4, 2):
            vector = _fold_pair(builder, vector, vector, group)
        return builder.extract_element(vector, ir.Constant(ir.IntType(32), 0))

    return types.float32(VECTOR), codegen


@intrinsic
def add_row_sums(typingctx, rows, start, like, sums, to):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Add to ``sums``, from place ``to`` on, the sums of consecutive rows of sixteen numbers in ``rows``.

    As many rows as the tuple ``like`` is long; a multiple of sixteen elements of ``sums`` is written, with 0 added to the
    superfluous ones. Sixteen rows are folded together, which takes a third of the instructions that folding each would.
    """
    count = len(like)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        def element(place: int, offset: int) -> Any:
            index = builder.add(arguments[place + 1], ir.Constant(arguments[place + 1].type, offset))
            return _address(context, builder, signature.args[place], arguments[place], index)

        for first in range(0, count, LANES):
            here = range(first, min(first + LANES, count))
            vectors = [builder.load(element(0, row * LANES), align=4, typ=_FLOATS) for row in here]
            group = LANES
            while group > 1:
                pairs = [(vectors[k], (vectors[k + 1 : k + 2] or [_constant(0.0)])[0]) for k in range(0, len(vectors), 2)]
                vectors = [_fold_pair(builder, a, b, group) for a, b in pairs]
                group //= 2
            target = element(3, first)
            total = builder.fadd(builder.load(target, align=4, typ=_FLOATS), vectors[0])
            builder.store(total, target, align=4)
        return context.get_dummy_value()

    return types.void(rows, types.intp, like, sums, types.intp), codegen


@register_jitable
def aligned_empty(count):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Return ``count`` float32 elements of memory that begin at a cache line, so that no vector in it straddles two."""
    room = np.empty(count + LANES, np.float32)
    start = (-room.ctypes.data % 64) // 4
    return room[start : start + count]


@register_jitable
def aligned_full(count, value):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Return :func:`aligned_empty` filled with ``value``."""
    array = aligned_empty(count)
    for k in range(count):
        array[k] = np.float32(value)
    return array
