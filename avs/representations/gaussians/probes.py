"""Fisher information estimated by random signs: works with every rasteriser that has gradients, so on a GPU, too."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import torch
from torch import Tensor

from avs.rasterizer.rasterization import rasterization
from avs.representations.capabilities import FisherInformation
from avs.representations.gaussians.parameter_information import activated, as_columns, check_options
from avs.representations.gaussians.parameters import NAMES, Parameters
from avs.scene.cameras import Cameras


def probe_views(
    parameters: Parameters,
    cameras: Cameras,
    sh_degree: int,
    background: Tensor,
    chain: str,
    groups: Sequence[str],
    probes: int,
    seeds: Sequence[int],
) -> Iterator[FisherInformation]:
    """Yield estimates of what ``information.parameter_fisher`` computes exactly, camera by camera.

    With a random sign v for each pixel, shared by its channels, as the gradient of the image, the gradient of a
    parameter is sum_p v_p g_p, g_p being the derivative of the channel sum of pixel p; the mean of its square is
    sum_p g_p^2 (Hutchinson's estimator). The image is rendered once, then differentiated ``probes`` times.

    Args:
        parameters: of n Gaussians, on any device.
        cameras: of any sizes.
        sh_degree: degree in use.
        background: colour behind the Gaussians ``[1, 3]``, on the same device.
        chain: as in ``parameter_fisher``.
        groups: as in ``parameter_fisher``.
        probes: sign images per camera, whose squares are averaged.
        seeds: one per camera, so that a camera's estimate does not depend on the others.

    Raises:
        UserError: the chain or a group is not known.
    """
    check_options(chain, groups)
    values = activated({name: parameter.detach() for name, parameter in parameters.items()})
    values["sh"] = values["sh"][:, : (sh_degree + 1) ** 2].contiguous()
    return (
        _of_camera(values, cameras[index], sh_degree, background, chain, groups, probes, seed)
        for index, seed in zip(range(len(cameras)), seeds, strict=True)
    )


def _of_camera(
    values: Mapping[str, Tensor],
    camera: Cameras,
    sh_degree: int,
    background: Tensor,
    chain: str,
    groups: Sequence[str],
    probes: int,
    seed: int,
) -> FisherInformation:
    """Return one camera's estimate; ``values`` are after activation."""
    width, height = (int(side) for side in camera.sizes[0])
    device = background.device
    wanted = sorted({"sh" if name in ("f_dc", "f_rest") else name for name in groups})
    leaves = {name: values[name].clone().requires_grad_(name in wanted) for name in NAMES}
    image, _, _ = rasterization(
        means=leaves["means"],
        quats=leaves["quats"],
        scales=leaves["scales"],
        opacities=leaves["opacities"],
        colors=leaves["sh"],
        viewmats=torch.tensor(camera.world_to_camera, dtype=torch.float32, device=device),
        Ks=torch.tensor(camera.intrinsics, dtype=torch.float32, device=device),
        width=width,
        height=height,
        sh_degree=sh_degree,
        packed=False,
        backgrounds=background,
    )
    generator = np.random.Generator(np.random.PCG64(seed))
    tensors = [leaves[name] for name in wanted]
    squares = [torch.zeros_like(tensor) for tensor in tensors]
    for _ in range(probes):
        signs = torch.from_numpy(generator.choice(np.array([-1, 1], dtype=np.float32), (1, height, width, 1)))
        gradients = torch.autograd.grad(image, tensors, signs.to(device).expand_as(image), retain_graph=True)
        for square, gradient in zip(squares, gradients, strict=True):
            square.addcmul_(gradient, gradient, value=1 / probes)
    together = torch.cat([square.reshape(len(square), -1) for square in squares], dim=1)
    rows = torch.nonzero(together.any(dim=1))[:, 0]
    sums = {name: square[rows] for name, square in zip(wanted, squares, strict=True)}
    columns = as_columns(sums, values["scales"][rows], values["opacities"][rows], chain, groups)
    return FisherInformation(rows.cpu().numpy(), columns.cpu().numpy(), len(values["means"]))
