"""How every compiled function of the rasteriser is compiled."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy.typing as npt

# For the signatures of compiled functions. A number is a scalar or sixteen of them, as in ``simd``.
Floats = npt.NDArray[Any]
Integers = npt.NDArray[Any]
Number = Any
Compiled = Any
# The context of a torch.autograd.Function, on which attributes are set freely.
Context = Any
Numbers = tuple[Number, ...]


def _stamp() -> bytes:
    """Return a digest of all files here: of compiled functions, and of the constants that are compiled into them."""
    sources = [path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))]
    return hashlib.sha256(b"".join(sources)).digest()


_STAMP = _stamp()


def kernel(function: Callable[..., Any], fastmath: bool | set[str] = False) -> Compiled:
    """Compile ``function`` for this machine and keep the machine code on disk.

    The code is kept beside the source or, where that is read-only, in the user's cache folder (``NUMBA_CACHE_DIR``
    names another). With neither at hand each process compiles again. ``fastmath`` is numba's.
    """
    options: Any = {"error_model": "numpy", "nogil": True, "fastmath": fastmath}
    try:
        compiled = numba.njit(cache=True, **options)(function)
    except RuntimeError:
        return numba.njit(**options)(function)
    # numba looks at the function's own file only, and would go on using code into which an older version of a function
    # of another file has been compiled (https://numba.readthedocs.io/en/stable/developer/caching.html).
    compiled._cache._cache_file._source_stamp = _STAMP
    return compiled


def inline(function: Callable[..., Any]) -> Compiled:
    """Compile ``function`` into each kernel that calls it."""
    return numba.njit(error_model="numpy", forceinline=True)(function)
