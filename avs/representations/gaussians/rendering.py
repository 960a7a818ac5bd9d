"""How Gaussians are given to the rasteriser, for the optimisation and for a rendering."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor

from avs.rasterizer.rasterization import rasterization
from avs.representations.base import Rendering
from avs.representations.gaussians.gaussian_settings import CAMERAS_PER_BATCH
from avs.representations.gaussians.parameters import Parameters
from avs.scene.cameras import Cameras


def rendered(parameters: Parameters, cameras: Cameras, degree: int, background: Tensor) -> Rendering:
    """Return what Gaussians look like from ``cameras``, which share one image size, in batches.

    Args:
        parameters: the Gaussians.
        cameras: n cameras.
        degree: of the spherical harmonics in use.
        background: ``[1, 3]`` sRGB in 0..1, on the parameters' device.

    Raises:
        ValueError: the image sizes differ, or there is no camera.
    """
    sizes = list(cameras.by_size())
    if len(sizes) != 1:
        raise ValueError(f"expected cameras of one image size, got {len(sizes)} sizes")
    batches = [cameras[i : i + CAMERAS_PER_BATCH] for i in range(0, len(cameras), CAMERAS_PER_BATCH)]
    with torch.no_grad():
        parts = [
            rasterization(
                **rasterizer_arguments(parameters, batch, degree, background), packed=False, render_mode="RGB+ED"
            )[:2]
            for batch in batches
        ]
    image = torch.cat([image for image, _ in parts]).cpu()
    alpha = torch.cat([alpha for _, alpha in parts]).cpu()[..., 0]
    depth = torch.where(alpha > 0, image[..., 3], torch.zeros(()))
    return Rendering(
        rgb=image[..., :3].clamp(0, 1).contiguous().numpy(), depth=depth.numpy(), alpha=alpha.clamp(0, 1).numpy()
    )


def rasterizer_arguments(
    parameters: Parameters, cameras: Cameras, degree: int, background: Tensor, *, absolute: bool = False
) -> dict[str, Any]:
    """Return the arguments with which the rasteriser renders cameras of one image size.

    Args:
        parameters: the Gaussians.
        cameras: n cameras.
        degree: of the spherical harmonics in use.
        background: ``[1, 3]`` sRGB in 0..1, on the parameters' device.
        absolute: whether absolute gradients of the image positions are kept, too.
    """
    width, height = (int(side) for side in cameras.sizes[0])
    return {
        "means": parameters["means"],
        "quats": parameters["quats"],
        "scales": parameters["scales"].exp(),
        "opacities": parameters["opacities"].sigmoid(),
        "colors": parameters["sh"],
        "viewmats": torch.tensor(cameras.world_to_camera, dtype=torch.float32, device=background.device),
        "Ks": torch.tensor(cameras.intrinsics, dtype=torch.float32, device=background.device),
        "width": width,
        "height": height,
        "sh_degree": degree,
        "absgrad": absolute,
        "backgrounds": background.expand(len(cameras), -1),
    }
