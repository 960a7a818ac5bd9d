"""Nerfacto, a radiance field of hashed grids with proposal sampling (arXiv 2302.04264), on the CPU and on CUDA."""

from avs.representations.base import Kind
from avs.representations.nerfacto.nerfacto_settings import NerfactoSettings

KIND = Kind(
    settings=NerfactoSettings,
    offers=frozenset({"copy"}),
    exports="nerfacto.safetensors",
    build="avs.representations.nerfacto.nerfacto_field:build",
    compile="avs.representations.nerfacto.nerfacto_compilation:compile_nerfacto",
)
