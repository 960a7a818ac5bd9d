"""Variance that views remove, by the Gaussians' learned variances: the rasteriser's, camera by camera."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from avs.rasterizer.variance_rasterization import variance_reduction
from avs.representations.gaussians.parameter_information import activated
from avs.representations.gaussians.parameters import Parameters
from avs.representations.learned_variance import VarianceReduction
from avs.scene.cameras import Cameras


@torch.no_grad()
def variance_reductions(
    parameters: Parameters, variances: Tensor, cameras: Cameras, attenuated: bool, rule: VarianceReduction
) -> npt.NDArray[np.float64]:
    """Return, for each of n cameras, the variance that its view removes, summed over pixels: ``[n]``.

    Args:
        parameters: of N Gaussians, before activation.
        variances: ``[N]`` float32.
        cameras: of any sizes.
        attenuated: as in ``variance_rasterization.rasterization_with_variance``.
        rule: what is counted.
    """
    tensors = activated(parameters)
    matrices = torch.tensor(cameras.world_to_camera, dtype=torch.float32, device=variances.device)
    intrinsics = torch.tensor(cameras.intrinsics, dtype=torch.float32, device=variances.device)
    reductions = [
        variance_reduction(
            tensors["means"],
            tensors["quats"],
            tensors["scales"],
            tensors["opacities"],
            variances,
            matrices[c],
            intrinsics[c],
            int(width),
            int(height),
            attenuated,
            rule.constant,
            rule.weighted,
            rule.saturated,
        )
        for c, (width, height) in enumerate(cameras.sizes)
    ]
    return np.array(reductions, dtype=np.float64)
