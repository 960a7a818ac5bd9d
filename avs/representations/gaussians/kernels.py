"""How every compiled function of the rasteriser is compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(function: Function) -> Function:
    """Compile ``function`` for this machine and keep the machine code on disk.

    The code is kept beside the source or, where that is read-only, in the user's cache folder (``NUMBA_CACHE_DIR`` names
    another). With neither at hand each process compiles anew.
    """
    options: dict[str, Any] = {"error_model": "numpy", "nogil": True}
    try:
        return cast(Function, numba.njit(cache=True, **options)(function))
    except RuntimeError:
        return cast(Function, numba.njit(**options)(function))


def inline(function: Function) -> Function:
    """Compile ``function`` into each kernel that calls it."""
    return cast(Function, numba.njit(error_model="numpy", forceinline=True)(function))
