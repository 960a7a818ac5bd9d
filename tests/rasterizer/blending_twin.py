"""Blending weights by the slow renderer: the derivatives of pixels by the Gaussians' colours."""

import numpy as np
import torch

from avs.representations.gaussians.gaussian_settings import GaussianSettings
from avs.representations.gaussians.initialization import PointCloud
from avs.representations.gaussians.splats import GaussianSplats
from tests.rasterizer import reference_renderer as reference

COUNT = 40


def splats(opacity=0.7):
    """Return Gaussians of all shapes; the larger ``opacity``, the more of them are opaque."""
    generator = np.random.default_rng(2)
    cloud = PointCloud(generator.normal(size=(COUNT, 3)), generator.random((COUNT, 3)))
    representation = GaussianSplats(cloud, 1.0, GaussianSettings(), np.random.default_rng(0), "cpu")
    with torch.no_grad():
        for name, spread in (("scales", 0.5), ("quats", 1.0), ("opacities", 2.0)):
            values = representation.parameters[name]
            values += spread * torch.from_numpy(generator.normal(size=tuple(values.shape))).float()
        representation.parameters["opacities"] += opacity
    return representation


def weights(representation, camera):
    """Return the weights ``[pixels, Gaussians]`` and the transmittances in front, in float64."""
    (width, height), view = camera.sizes[0].tolist(), torch.tensor(camera.world_to_camera[0])
    tensors = {name: values.detach().double() for name, values in representation.parameters.items()}
    shape = (tensors["means"], tensors["quats"], tensors["scales"].exp(), tensors["opacities"].sigmoid())

    def image(colors):
        intrinsics = torch.tensor(camera.intrinsics[0])
        return reference.render(*shape, colors, view, intrinsics, width, height)[0].reshape(-1)

    found = torch.autograd.functional.jacobian(image, torch.zeros(len(tensors["means"]), 1, dtype=torch.float64))[
        :, :, 0
    ]
    depths = tensors["means"] @ view[2, :3] + view[2, 3]
    order = torch.argsort(depths)
    before = torch.zeros_like(found)
    before[:, order] = 1 - found[:, order].cumsum(dim=1) + found[:, order]
    return found.numpy(), before.numpy()
