"""3D Gaussian splatting (Kerbl et al. 2023, arXiv 2308.04079), on the CPU and on CUDA."""

from avs.representations.base import Kind
from avs.representations.gaussians.gaussian_settings import GaussianSettings

KIND = Kind(
    settings=GaussianSettings,
    offers=frozenset({"copy", "fisher_diagonal", "fisher_probes", "blending_weights", "learned_variance"}),
    exports="splats.ply",
    build="avs.representations.gaussians.splats:build",
    on_cpu=frozenset({"fisher_diagonal", "blending_weights"}),
    compile="avs.representations.gaussians.compilation:compile_kernels",
)
