"""Sixteen float32 numbers as one value inside numba kernels.

The rasteriser's inner loops handle sixteen pixels, or sixteen Gaussians, at once. Left to LLVM's loop vectoriser, such
a loop is at the mercy of run-time alias checks, of reassociation flags and of what changed in the last release; here
it is spelled out with LLVM's vector types, which every back end lowers (AVX-512: one register, AVX2: two, NEON: four).

No operation carries a fast-math flag and products are fused only where :func:`fma` says so. The same expression thus
gives the same bits wherever it is compiled, which the backward pass relies on: it recomputes the opacities of the
forward pass and must take the same decisions.

Arithmetic operators, comparisons and ``&`` work as on numbers; a scalar operand is broadcast. :func:`fma`,
:func:`minimum`, :func:`maximum`, :func:`where` and :func:`square_root` take scalars, too, so that a formula can be
written once for one Gaussian and for sixteen.
"""

import operator
from collections.abc import Callable
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, overload, register_model

from avs.rasterizer.simd_masks import BITS, bits, both, compared, selected
from avs.rasterizer.simd_types import FLOATS, INT, INTS, LANES, Part, call

# numba wants an implementation's parameters named and annotated as those of the function that chooses it: lambdas.
_overload = cast("Callable[[Callable[..., Any]], Callable[[Callable[..., Any]], Any]]", overload)
_intrinsic = cast("Callable[[Callable[..., Any]], Any]", intrinsic)


class _Vector(types.Type):
    """Numba type of sixteen float32 numbers."""

    def __init__(self) -> None:
        super().__init__(name="float32x16")


class _Mask(types.Type):
    """Numba type of sixteen truth values."""

    def __init__(self) -> None:
        super().__init__(name="bool_x16")


VECTOR = _Vector()
MASK = _Mask()


@register_model(_Vector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, dmm: Part, fe_type: Part) -> None:
        super().__init__(dmm, fe_type, FLOATS)  # type: ignore[no-untyped-call]


@register_model(_Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm: Part, fe_type: Part) -> None:
        super().__init__(dmm, fe_type, BITS)  # type: ignore[no-untyped-call]


def constant(value: float) -> ir.Constant:
    """Return sixteen times ``value`` for use in a code generator."""
    return ir.Constant(FLOATS, [float(np.float32(value))] * LANES)


def _integers(value: int) -> ir.Constant:
    return ir.Constant(INTS, [value] * LANES)


def _broadcast(builder: Part, scalar: Part) -> Part:
    one = builder.insert_element(ir.Constant(FLOATS, ir.Undefined), scalar, ir.Constant(INT, 0))
    return builder.shuffle_vector(one, ir.Constant(FLOATS, ir.Undefined), ir.Constant(INTS, [0] * LANES))


def _as_vector(context: Part, builder: Part, value: Part, kind: Part) -> Part:
    if isinstance(kind, _Vector):
        return value
    return _broadcast(builder, context.cast(builder, value, kind, types.float32))


def _elementwise(arity: int, result: types.Type, emit: Callable[..., Any]) -> Part:
    """Return an intrinsic of ``arity`` operands, each a vector or a scalar to be broadcast."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        vectors = [_as_vector(context, builder, a, k) for a, k in zip(arguments, signature.args, strict=True)]
        return emit(builder, *vectors)

    if arity == 1:

        @_intrinsic
        def one(typingctx: Part, a: Part) -> Part:
            return result(a), codegen

        return one
    if arity == 2:

        @_intrinsic
        def two(typingctx: Part, a: Part, b: Part) -> Part:
            return result(a, b), codegen

        return two

    @_intrinsic
    def three(typingctx: Part, a: Part, b: Part, c: Part) -> Part:
        return result(a, b, c), codegen

    return three


def _is_vector(*kinds: Part) -> bool:
    return any(isinstance(kind, _Vector) for kind in kinds)


def _overload_operator(function: Callable[..., Any], result: types.Type, emit: Callable[..., Any]) -> None:
    two = _elementwise(2, result, emit)

    _overload(function)(lambda a, b: (lambda a, b: two(a, b)) if _is_vector(a, b) else None)


_overload_operator(operator.add, VECTOR, lambda builder, a, b: builder.fadd(a, b))
_overload_operator(operator.sub, VECTOR, lambda builder, a, b: builder.fsub(a, b))
_overload_operator(operator.mul, VECTOR, lambda builder, a, b: builder.fmul(a, b))
_overload_operator(operator.truediv, VECTOR, lambda builder, a, b: builder.fdiv(a, b))
for _function, _sign in ((operator.gt, ">"), (operator.ge, ">="), (operator.lt, "<"), (operator.le, "<=")):
    _overload_operator(_function, MASK, lambda builder, a, b, sign=_sign: compared(builder, sign, a, b))


@_intrinsic
def _negative(typingctx: Part, a: Part) -> Part:
    return VECTOR(a), lambda context, builder, signature, arguments: builder.fneg(arguments[0])


_overload(operator.neg)(lambda a: (lambda a: _negative(a)) if _is_vector(a) else None)


@_intrinsic
def _mask_and(typingctx: Part, a: Part, b: Part) -> Part:
    return MASK(a, b), lambda context, builder, signature, arguments: both(builder, *arguments)


_overload(operator.and_)(lambda a, b: (lambda a, b: _mask_and(a, b)) if isinstance(a, _Mask) else None)


@_intrinsic
def any_of(typingctx: Part, mask: Part) -> Part:
    """Return whether any of the sixteen truth values holds."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        return builder.icmp_unsigned("!=", bits(builder, arguments[0]), ir.Constant(INT, 0))

    return types.boolean(mask), codegen


@_intrinsic
def bits_of(typingctx: Part, mask: Part) -> Part:
    """Return the sixteen truth values as an integer, the first as its lowest bit."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        return bits(builder, arguments[0])

    return types.uint32(mask), codegen


@_intrinsic
def lowest_bit(typingctx: Part, bits: Part) -> Part:
    """Return the place of the lowest bit that is set; there must be one."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 1))

    return types.uint32(types.uint32), codegen


broadcast = _elementwise(1, VECTOR, lambda builder, a: a)

_fma = _elementwise(3, VECTOR, lambda builder, a, b, c: call(builder, "llvm.fmuladd.v16f32", FLOATS, [a, b, c]))
_minimum = _elementwise(2, VECTOR, lambda builder, a, b: builder.select(builder.fcmp_ordered("<", a, b), a, b))
_maximum = _elementwise(2, VECTOR, lambda builder, a, b: builder.select(builder.fcmp_ordered(">", a, b), a, b))
_square_root = _elementwise(1, VECTOR, lambda builder, a: call(builder, "llvm.sqrt.v16f32", FLOATS, [a]))
_absolute = _elementwise(1, VECTOR, lambda builder, a: call(builder, "llvm.fabs.v16f32", FLOATS, [a]))


floor = _elementwise(1, VECTOR, lambda builder, a: call(builder, "llvm.floor.v16f32", FLOATS, [a]))
ceil = _elementwise(1, VECTOR, lambda builder, a: call(builder, "llvm.ceil.v16f32", FLOATS, [a]))


@_intrinsic
def _select(typingctx: Part, mask: Part, a: Part, b: Part) -> Part:
    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        pair = [_as_vector(context, builder, x, k) for x, k in zip(arguments[1:], signature.args[1:], strict=True)]
        return selected(builder, arguments[0], *pair)

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


_overload(fma)(lambda a, b, c: (lambda a, b, c: _fma(a, b, c)) if _is_vector(a, b, c) else (lambda a, b, c: a * b + c))
_overload(minimum)(lambda a, b: (lambda a, b: _minimum(a, b)) if _is_vector(a, b) else (lambda a, b: a if a < b else b))
_overload(maximum)(lambda a, b: (lambda a, b: _maximum(a, b)) if _is_vector(a, b) else (lambda a, b: a if a > b else b))
_overload(where)(
    lambda mask, a, b: (
        (lambda mask, a, b: _select(mask, a, b)) if isinstance(mask, _Mask) else (lambda mask, a, b: a if mask else b)
    )
)
_overload(square_root)(lambda a: (lambda a: _square_root(a)) if _is_vector(a) else (lambda a: np.sqrt(a)))
_overload(absolute)(lambda a: (lambda a: _absolute(a)) if _is_vector(a) else (lambda a: abs(a)))


# 2^f on [-1/2, 1/2], minimax in the relative error, which is 9.2e-8 before rounding (linear programme on 2001 points).
_EXP2_COEFFICIENTS = (1.0, 0.69314700, 0.24022242, 0.055507336, 0.0096715130, 0.0013264727)
# Adding 1.5 * 2^23 rounds to the nearest integer and leaves it in the low bits of the sum.
_ROUNDING = 12582912.0


@_intrinsic
def exp2(typingctx: Part, exponent: Part) -> Part:
    """Return two to the power of each of sixteen numbers in -100..100; beyond, any bits may come back, NaN too."""

    def codegen(context: Part, builder: Part, signature: Part, arguments: Part) -> Part:
        shifted = builder.fadd(arguments[0], constant(_ROUNDING))
        fraction = builder.fsub(arguments[0], builder.fsub(shifted, constant(_ROUNDING)))
        value = constant(_EXP2_COEFFICIENTS[-1])
        for coefficient in _EXP2_COEFFICIENTS[-2::-1]:
            value = call(builder, "llvm.fmuladd.v16f32", FLOATS, [value, fraction, constant(coefficient)])
        exponent_bits = builder.shl(builder.bitcast(shifted, INTS), _integers(23))
        return builder.bitcast(builder.add(builder.bitcast(value, INTS), exponent_bits), FLOATS)

    return VECTOR(VECTOR), codegen
