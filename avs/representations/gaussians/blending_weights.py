"""Blending weights of single Gaussians: numbers of the Gaussians blended into an image, and sums of weights back."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import torch

from avs.rasterizer.front_weights import weights_in_front
from avs.rasterizer.rasterization import rasterization
from avs.representations.gaussians.parameter_information import activated
from avs.representations.gaussians.parameters import Parameters
from avs.scene.cameras import Cameras

WeightSums = tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]


@torch.no_grad()
def blended_values(parameters: Parameters, camera: Cameras, values: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return the image ``[height, width]`` of ``values`` ``[n]``, blended as colours are, black behind."""
    device = parameters["means"].device
    tensors = activated(parameters)
    width, height = (int(side) for side in camera.sizes[0])
    image, _, _ = rasterization(
        means=tensors["means"],
        quats=tensors["quats"],
        scales=tensors["scales"],
        opacities=tensors["opacities"],
        colors=torch.from_numpy(values)[:, None].to(device),
        viewmats=torch.tensor(camera.world_to_camera, dtype=torch.float32, device=device),
        Ks=torch.tensor(camera.intrinsics, dtype=torch.float32, device=device),
        width=width,
        height=height,
        packed=False,
    )
    return np.asarray(image[0, :, :, 0].cpu().numpy())


@torch.no_grad()
def front_weights(
    parameters: Parameters, camera: Cameras, image: npt.NDArray[np.float32], transmittance: float
) -> WeightSums:
    """Return, per Gaussian, the sum of weight times ``image`` over the pixels where it lies in front, and their number.

    It lies in front where the transmittance that reaches it is above ``transmittance``. Computed on the CPU, on copies
    of the parameters where these are elsewhere.

    Args:
        parameters: of n Gaussians, before activation.
        camera: one camera.
        image: ``[height, width]``.
        transmittance: 0 counts every pixel that a Gaussian is blended into.

    Returns:
        Sums ``[n]`` and numbers of pixels ``[n]``.
    """
    tensors = activated({name: parameter.detach().cpu() for name, parameter in parameters.items()})
    return weights_in_front(
        means=tensors["means"],
        quats=tensors["quats"],
        scales=tensors["scales"],
        opacities=tensors["opacities"],
        viewmat=torch.tensor(camera.world_to_camera[0], dtype=torch.float32),
        intrinsics=torch.tensor(camera.intrinsics[0], dtype=torch.float32),
        image=image,
        transmittance=transmittance,
    )
