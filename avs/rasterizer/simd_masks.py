"""Sixteen truth values: how comparisons make them, and what is done with them.

LLVM's own are of one bit each. For AVX2, which has registers of eight numbers, it packs those of sixteen into bytes and
unpacks them again at each use; kernels that blend take a tenth longer for it. There a mask is what AVX compares to:
a vector of numbers whose bits are all set or all clear, handled half by half.
"""

import os

from llvmlite import binding, ir

from avs.rasterizer.simd_types import FLOAT, FLOATS, INT, INTS, LANES, Part, call


def _for_avx2() -> bool:
    """Return whether numba compiles for a processor, or a part of its instructions, with AVX2 and without AVX-512."""
    told = os.environ.get("NUMBA_CPU_FEATURES")
    features = (binding.get_host_cpu_features().flatten() if told is None else told).split(",")
    allowed = os.environ.get("NUMBA_ENABLE_AVX", "1") != "0"
    return allowed and "+avx2" in features and "+avx512f" not in features


AVX2 = _for_avx2()
BITS = FLOATS if AVX2 else ir.VectorType(ir.IntType(1), LANES)
"""LLVM's type of a mask."""

_HALF = ir.VectorType(FLOAT, LANES // 2)
# Numbers of AVX's comparisons; the two others have the operands exchanged. False where one is not a number.
_LESS, _LESS_OR_EQUAL = 1, 2


def compared(builder: Part, sign: str, a: Part, b: Part) -> Part:
    """Emit the mask of ``a sign b``; ``sign`` is ``<``, ``<=``, ``>`` or ``>=``."""
    if not AVX2:
        return builder.fcmp_ordered(sign, a, b)
    lesser, greater = (a, b) if sign[0] == "<" else (b, a)
    how = ir.Constant(ir.IntType(8), _LESS_OR_EQUAL if sign.endswith("=") else _LESS)
    pairs = zip(_halves(builder, lesser), _halves(builder, greater), strict=True)
    return _joined(builder, [call(builder, "llvm.x86.avx.cmp.ps.256", _HALF, [*pair, how]) for pair in pairs])


def both(builder: Part, a: Part, b: Part) -> Part:
    """Emit the mask that holds where both do."""
    if not AVX2:
        return builder.and_(a, b)
    return builder.bitcast(builder.and_(builder.bitcast(a, INTS), builder.bitcast(b, INTS)), FLOATS)


def selected(builder: Part, mask: Part, a: Part, b: Part) -> Part:
    """Emit ``a`` where ``mask`` holds, else ``b``."""
    if not AVX2:
        return builder.select(mask, a, b)
    parts = zip(*(_halves(builder, each) for each in (b, a, mask)), strict=True)
    return _joined(builder, [call(builder, "llvm.x86.avx.blendv.ps.256", _HALF, list(part)) for part in parts])


def bits(builder: Part, mask: Part) -> Part:
    """Emit the truth values as an integer of 32 bits, the first as its lowest bit."""
    if not AVX2:
        return builder.zext(builder.bitcast(mask, ir.IntType(LANES)), INT)
    low, high = (call(builder, "llvm.x86.avx.movmsk.ps.256", INT, [half]) for half in _halves(builder, mask))
    return builder.or_(low, builder.shl(high, ir.Constant(INT, LANES // 2)))


def _halves(builder: Part, vector: Part) -> list[Part]:
    lanes = [list(range(start, start + LANES // 2)) for start in (0, LANES // 2)]
    kind = ir.VectorType(INT, LANES // 2)
    nothing = ir.Constant(FLOATS, ir.Undefined)
    return [builder.shuffle_vector(vector, nothing, ir.Constant(kind, half)) for half in lanes]


def _joined(builder: Part, halves: list[Part]) -> Part:
    return builder.shuffle_vector(*halves, ir.Constant(INTS, list(range(LANES))))
