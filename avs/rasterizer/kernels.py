"""How every compiled function of the rasteriser is compiled."""

from __future__ import annotations

import functools
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


@functools.cache
def _stamp(folder: Path) -> bytes:
    """Return a digest of all files here and in ``folder``: of compiled functions, and of constants that are in them."""
    folders = {folder, Path(__file__).parent}
    sources = [path.read_bytes() for folder in sorted(folders) for path in sorted(folder.glob("*.py"))]
    return hashlib.sha256(b"".join(sources)).digest()


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
    compiled._cache._cache_file._source_stamp = _stamp(Path(function.__code__.co_filename).parent)
    compiled._cache.load_overload = _unless_damaged(compiled._cache)
    return compiled


def _unless_damaged(cache: Any) -> Callable[..., Any]:  # noqa: ANN401 - numba has no types
    """Return how ``cache`` loads compiled code, but for files that are cut off or not numba's: those are compiled anew.

    numba would let the fault of reading them end the process, this time and every time.
    """
    load = cache.load_overload

    def load_or_nothing(signature: Any, target: Any) -> Any:  # noqa: ANN401
        try:
            return load(signature, target)
        except Exception as error:
            print(f"{cache.cache_path}: compiled code is damaged ({type(error).__name__}), it is compiled anew")
            cache.flush()
            return None

    return load_or_nothing


def inline(function: Callable[..., Any]) -> Compiled:
    """Compile ``function`` into each kernel that calls it."""
    return numba.njit(error_model="numpy", forceinline=True)(function)
