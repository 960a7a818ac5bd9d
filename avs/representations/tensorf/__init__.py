"""TensoRF, a radiance field of vectors and matrices (Chen et al. 2022, arXiv 2203.09517), on the CPU and on CUDA."""

from avs.representations.base import Kind
from avs.representations.tensorf.tensorf_settings import TensorfSettings

KIND = Kind(
    settings=TensorfSettings,
    offers=frozenset({"copy"}),
    exports="tensorf.safetensors",
    build="avs.representations.tensorf.vector_matrix_field:build",
    compile="avs.representations.tensorf.vector_matrix_compilation:compile_tensorf",
)
