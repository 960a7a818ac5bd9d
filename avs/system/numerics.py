"""The same bits from every x86-64 processor: which instructions the libraries may use.

Compiled kernels, torch, oneDNN, MKL, OpenBLAS, NumPy and OpenCV choose their code by the processor that they find, and
sums and elementary functions end in other bits with each choice. One commit so gave another table on another machine,
apart by as much as seeds are. With ``portable`` numerics all of them are held to AVX2 and fused multiply-adds, which
every x86-64 processor has since 2015 or so; ``native`` leaves the choice to them. docs/numerics.md says what it costs
and how it was tested.

MKL is held to its compatible mode, because it treats the processors of one maker otherwise than those of others in any
other mode; ``portable_torch`` takes the work from it where that mode is slow or not portable after all.
"""

from __future__ import annotations

import functools
import os
import platform
import sys
from pathlib import Path
from typing import Literal, get_args

from avs.system.errors import UserError

Numerics = Literal["portable", "native"]

VARIABLE = "AVS_NUMERICS"
"""The environment variable that tells a process which numerics to use; portable if it is not set."""

NEEDED = ("avx2", "bmi2", "f16c", "fma")
"""What a processor must have, as Linux names it."""

# Each is read by its library when that is first imported.
_PORTABLE = {
    "ATEN_CPU_CAPABILITY": "avx2",
    "MKL_CBWR": "COMPATIBLE",
    "NPY_DISABLE_CPU_FEATURES": "X86_V4,AVX512_ICL,AVX512_SPR",
    "NUMBA_CPU_FEATURES": "+avx2,+bmi2,+f16c,+fma",
    "NUMBA_CPU_NAME": "haswell",
    "NUMBA_DISABLE_INTEL_SVML": "1",
    "ONEDNN_MAX_CPU_ISA": "AVX2",
    "OPENBLAS_CORETYPE": "Haswell",
    "OPENCV_IPP": "avx2",
}

_READERS = {"cv2", "numba", "numpy", "torch"}
_in_vain: list[bool] = []

# OpenCV prints a line where there is nothing to disable.
_WITH_AVX512 = {"OPENCV_CPU_DISABLE": "AVX512-SKX"}


def asked() -> Numerics:
    """Return the numerics that the environment asks for.

    Raises:
        UserError: the variable has another value.
    """
    value = os.environ.get(VARIABLE, "portable")
    for known in get_args(Numerics):
        if value == known:
            return known  # type: ignore[no-any-return]
    raise UserError(VARIABLE, f"{value} is none of {', '.join(get_args(Numerics))}", "set it to one of these")


def variables() -> dict[str, str]:
    """Return the environment variables that the numerics asked for need here; none where they cannot be had."""
    if asked() != "portable" or not processor_suffices():
        return {}
    return _PORTABLE | (_WITH_AVX512 if has_avx512() else {})


def set_variables() -> None:
    """Set the variables that are not set, which is in vain for libraries that have been imported before.

    Raises:
        UserError: as of ``asked``.
    """
    lacking = variables().keys() - os.environ.keys()
    if lacking and sys.modules.keys() & _READERS:
        _in_vain.append(True)
    os.environ.update({name: variables()[name] for name in lacking})


def in_force() -> Numerics:
    """Return the numerics of this process: portable only if every variable was set in time, and as it should be."""
    wanted = variables()
    holds = wanted and not _in_vain and all(os.environ.get(name) == wanted[name] for name in wanted)
    return "portable" if holds else "native"


def processor_suffices() -> bool:
    """Return whether this is Linux on an x86-64 processor with the instructions that portable numerics use."""
    return platform.system() == "Linux" and platform.machine() == "x86_64" and set(NEEDED) <= _flags()


def has_avx512() -> bool:
    """Return whether the processor has AVX-512, which portable numerics do without."""
    return "avx512f" in _flags()


@functools.cache
def _flags() -> frozenset[str]:
    """Return what the processor has, as Linux names it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return frozenset()
    return frozenset(next((line.split() for line in lines if line.startswith("flags")), []))
