"""Known obstacles of the environment and their cures. On a machine that does not need a cure it does nothing.

Call a cure just before the import that it serves; each may be called any number of times.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import os
import platform
import re
import sys
from pathlib import Path
from types import ModuleType

from avs.system import numerics
from avs.system.errors import UserError
from avs.system.stub_library import load_stub, undefined_symbols

# One process uses one thread, because the workflow runs as many processes as there are cores. OpenMP threads that
# wait actively for work made two busy processes ten times slower on two cores. The libraries read these variables at
# their first import.
_THREADS = {
    "OMP_NUM_THREADS": "1",
    "OMP_WAIT_POLICY": "passive",
    "MKL_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
}

# Without a network, huggingface_hub tries several times before it says so (about 50 s). Pretrained weights come from
# an explicit command only, which sets this to 0.
_HUB = {"HF_HUB_OFFLINE": "1", "HF_HUB_DISABLE_TELEMETRY": "1"}

# A process that shows no window must not look for a display.
_PLOTS = {"MPLBACKEND": "Agg"}

# Libraries that Open3D is linked to but that nothing here calls: the form of their functions' names, and their version.
_UNUSED_BY_OPEN3D = {
    "libGL.so.1": ("gl(X)?[A-Z]", ""),
    "libEGL.so.1": ("egl[A-Z]", ""),
    "libX11.so.6": ("X[A-Z]", ""),
    "libidn2.so.0": ("idn2_", "IDN2_0.0.0"),
    "libudev.so.1": ("udev_", "LIBUDEV_183"),
}


def variables() -> dict[str, str]:
    """Return the environment variables that ``prepare_environment`` sets, with their values.

    Raises:
        UserError: as of ``avs.system.numerics.asked``.
    """
    return _THREADS | _HUB | _PLOTS | numerics.variables()


def prepare_environment() -> None:
    """Set the environment variables of this module where the user has not set them.

    Call it before numpy, numba or torch is imported; a program's first line is the place. Child processes inherit them.
    The number of threads is set in any case: sums end in other bits with another one, and Snakemake tells each job by
    these variables how many cores it has, the timing of selections all of them.

    Raises:
        UserError: as of ``avs.system.numerics.asked``.
    """
    numerics.set_variables()
    os.environ.update(_THREADS)
    for name, value in variables().items():
        os.environ.setdefault(name, value)


def prepare_torch(threads: int = 1) -> None:
    """Make what torch computes repeatable; call it once torch is imported or about to be.

    Sums of floating-point numbers depend on how they are shared among threads, so their count is fixed. With portable
    numerics some operations are replaced: see ``avs.system.portable_torch``.
    """
    prepare_environment()
    import torch

    torch.set_num_threads(threads)
    if numerics.in_force() == "portable":
        from avs.system.portable_torch import replace_operations

        replace_operations()


@functools.cache
def prepare_torchvision() -> None:
    """Make ``import torchvision`` work beside a torch that its compiled operators do not fit.

    The package index serves torchvision built for CUDA. Beside a CPU torch its library does not load, because
    ``libtorch_cuda.so`` is missing, and then its import fails with "operator torchvision::nms does not exist": it
    describes the output shapes of operators that the library would have declared. Declaring them is enough; nothing
    here calls them, and a call would say that there is no implementation.
    """
    specification = importlib.util.find_spec("torchvision")
    if specification is None or specification.origin is None or "torchvision" in sys.modules:
        return
    import torch

    library = next(iter(Path(specification.origin).parent.glob("_C*.so")), None)
    if library is not None:
        try:
            torch.ops.load_library(library)  # type: ignore[no-untyped-call]
            return
        except OSError:
            pass
    for operator in ("nms", "qnms"):
        if not hasattr(torch.ops.torchvision, operator):
            schema = "(Tensor dets, Tensor scores, float iou_threshold) -> Tensor"
            torch.library.define(f"torchvision::{operator}", schema)


@functools.cache
def import_open3d() -> ModuleType:
    """Import Open3D and return it.

    Open3D's library is linked to libraries for windows, depth cameras and downloads, all unused here, which a minimal
    system lacks. The package ``libusb-package`` carries libusb; stand-ins serve for the others, because no package of
    the index carries them. What is loaded already, the linker takes for the library that Open3D needs.

    Raises:
        UserError: another system library that Open3D needs is missing, or Open3D itself.
    """
    if not _loads("libusb-1.0.so.0"):
        import libusb_package

        ctypes.CDLL(str(libusb_package.get_library_path()), mode=ctypes.RTLD_GLOBAL)
    if sys.platform == "linux" and platform.machine() == "x86_64":
        _stand_in_for_graphics()
    try:
        import open3d
    except ImportError as error:
        raise UserError(
            "open3d", str(error), "install environment.txt, and the system library that the message names"
        ) from error
    module: ModuleType = open3d
    return module


def _stand_in_for_graphics() -> None:
    """Load stand-ins for those libraries of ``_UNUSED_BY_OPEN3D`` that the system lacks."""
    missing = {name: functions for name, functions in _UNUSED_BY_OPEN3D.items() if not _loads(name)}
    specification = importlib.util.find_spec("open3d")
    if not missing or specification is None or specification.origin is None:
        return
    for library in Path(specification.origin).parent.glob("libOpen3D.so*"):
        symbols = undefined_symbols(library)
        for name, (pattern, version) in missing.items():
            load_stub(name, [symbol for symbol in symbols if re.match(pattern, symbol)], version)


def _loads(library: str) -> bool:
    """Whether the dynamic linker finds ``library``."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
