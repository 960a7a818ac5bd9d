"""LLVM's types of sixteen numbers, and calls of its intrinsics, for the code generators of ``simd``."""

from typing import Any

from llvmlite import ir
from numba.core.cgutils import get_or_insert_function

LANES = 16
# A value of LLVM, a numba type, or the object that carries them.
Part = Any

FLOAT = ir.FloatType()
INT = ir.IntType(32)
FLOATS = ir.VectorType(FLOAT, LANES)
INTS = ir.VectorType(INT, LANES)


def call(builder: Part, name: str, result: Part, arguments: list[Part]) -> Part:
    """Emit a call of one of LLVM's intrinsics."""
    signature = ir.FunctionType(result, [argument.type for argument in arguments])
    function = get_or_insert_function(builder.module, signature, name)  # type: ignore[no-untyped-call]
    return builder.call(function, arguments)
