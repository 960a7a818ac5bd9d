"""3D Gaussian splatting (Kerbl et al. 2023, arXiv 2308.04079), on the CPU and on CUDA.

``rasterization``, ``build``, ``GaussianSplats`` and ``GaussianSettings`` are the public names.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from avs.rasterizer.rasterization import rasterization
    from avs.representations.gaussians.gaussian_settings import GaussianSettings
    from avs.representations.gaussians.splats import GaussianSplats, build

__all__ = ["GaussianSettings", "GaussianSplats", "build", "rasterization"]

# No name of a module is a public name as well: importing a module would put it in the place of the name.
_MODULES = {
    "GaussianSettings": "settings",
    "GaussianSplats": "splats",
    "build": "splats",
    "rasterization": "rasterizer",
}


def __getattr__(name: str) -> object:
    """Import a public name on first use: the settings, in the same package, are read where torch is not wanted."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
