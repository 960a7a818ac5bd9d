"""How every compiled function of the rasteriser is compiled."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])


def _stamp() -> bytes:
    """Return a digest of all files here that define compiled functions."""
    sources = [path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))]
    return hashlib.sha256(b"".join(source for source in sources if b"numba" in source or b".kernels" in source)).digest()


_STAMP = _stamp()


def kernel(function: Function) -> Function:
    """Compile ``function`` for this machine and keep the machine code on disk.

    The code is kept beside the source or, where that is read-only, in the user's cache folder (``NUMBA_CACHE_DIR`` names
    another). With neither at hand each process compiles anew.
    """
    options: dict[str, Any] = {"error_model": "numpy", "nogil": True}
    try:
        compiled = numba.njit(cache=True, **options)(function)
    except RuntimeError:
        return cast(Function, numba.njit(**options)(function))
    # numba looks at the function's own file only, and would go on using code into which an older version of a function of
    # another file has been compiled (https://numba.readthedocs.io/en/stable/developer/caching.html).
    compiled._cache._cache_file._source_stamp = _STAMP
    return cast(Function, compiled)


def inline(function: Function) -> Function:
    """Compile ``function`` into each kernel that calls it."""
    return cast(Function, numba.njit(error_model="numpy", forceinline=True)(function))
