"""Blending weights of single Gaussians: numbers of the Gaussians blended into an image, and sums of weights back."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import torch

from avs.rasterizer.blending import blend
from avs.rasterizer.front_weights import front_sums
from avs.rasterizer.projection import project_gaussians
from avs.rasterizer.rasterization import rasterization
from avs.rasterizer.splat_records import pack_records
from avs.rasterizer.tiles import depth_order
from avs.representations.gaussians.parameter_information import activated
from avs.representations.gaussians.parameters import Parameters
from avs.scene.cameras import Cameras

WeightSums = tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]

# The defaults of ``rasterization``.
_NEAR, _FAR, _BLUR = 0.01, 1e10, 0.3


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
    width, height = (int(side) for side in camera.sizes[0])
    means, quats, scales, opacities = (tensors[name] for name in ("means", "quats", "scales", "opacities"))
    means2d, depths, conics, _, radii = project_gaussians(
        means, quats, scales, opacities,
        torch.tensor(camera.world_to_camera, dtype=torch.float32),
        torch.tensor(camera.intrinsics, dtype=torch.float32),
        width, height, _NEAR, _FAR, 0.0, _BLUR, False,
    )  # fmt: skip
    centre, depth, conic, radius = (x[0].numpy() for x in (means2d, depths, conics, radii))
    order = depth_order(depth, radius)
    no_colors = np.empty((len(depth), 0), np.float32)
    records = pack_records(order, centre, conic, opacities.numpy(), no_colors, depth, radius, False)
    _, _, entries, offsets = blend(records, (), (), 0.0, width, height)
    sums, pixels = np.zeros(len(depth)), np.zeros(len(depth), np.int64)
    sums[order], pixels[order] = front_sums(
        records, entries, offsets, np.ascontiguousarray(image, dtype=np.float32), np.float32(transmittance)
    )
    return sums, pixels
