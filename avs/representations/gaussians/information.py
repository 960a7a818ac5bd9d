"""Fisher information of the parameters that are optimised: the rasteriser's, taken through the activations."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from avs.cameras import Cameras
from avs.errors import UserError
from avs.representations.gaussians.fisher import fisher_diagonal
from avs.representations.gaussians.parameters import Parameters

EXPONENTS = {"once": 1, "squared": 2}
"""Power of the derivative of an activation, by chain.

FisherRF squares inside its rasteriser, with respect to the activated scale s and opacity o, and lets autograd multiply
once: H s and H o (1 - o). The diagonal of the Gauss-Newton matrix has these factors squared.
"""


def parameter_fisher(
    parameters: Parameters, cameras: Cameras, sh_degree: int, background: tuple[float, float, float], chain: str
) -> Iterator[npt.NDArray[np.float32]]:
    """Yield ``[n, 7 + 3 (d + 1)^2]`` arrays, camera by camera, d being the highest degree of the harmonics.

    Columns (55 for d = 3): position (3), harmonics of degree 0 (3), of higher degrees (0 above ``sh_degree``),
    log-scale (3), logit of the opacity (1). Rotations are left out, as FisherRF does by default. The sums are exact;
    they are computed on the CPU, on copies of the parameters where these are elsewhere.

    Args:
        parameters: of n Gaussians.
        cameras: of any sizes.
        sh_degree: degree in use.
        background: colour behind the Gaussians.
        chain: ``once`` or ``squared``, see ``EXPONENTS``.

    Raises:
        UserError: the chain is not known.
    """
    if chain not in EXPONENTS:
        raise UserError(f"chain {chain!r}", "is not known", f"choose one of {', '.join(EXPONENTS)}")
    values = {name: parameter.detach().cpu() for name, parameter in parameters.items()}
    values["scales"], values["opacities"] = values["scales"].exp(), values["opacities"].sigmoid()
    behind = torch.tensor(background, dtype=torch.float32)
    return (_columns(values, cameras[index], sh_degree, behind, EXPONENTS[chain]) for index in range(len(cameras)))


def _columns(
    values: dict[str, Tensor], camera: Cameras, sh_degree: int, background: Tensor, exponent: int
) -> npt.NDArray[np.float32]:
    """Return one camera's array; ``values`` are after activation."""
    width, height = (int(side) for side in camera.sizes[0])
    diagonal = fisher_diagonal(
        means=values["means"],
        quats=values["quats"],
        scales=values["scales"],
        opacities=values["opacities"],
        sh_coefficients=values["sh"],
        viewmat=torch.tensor(camera.world_to_camera[0], dtype=torch.float32),
        intrinsics=torch.tensor(camera.intrinsics[0], dtype=torch.float32),
        width=width,
        height=height,
        sh_degree=sh_degree,
        background=background,
    )
    by_scale = diagonal.scales * values["scales"] ** exponent
    by_opacity = diagonal.opacities * (values["opacities"] * (1 - values["opacities"])) ** exponent
    columns = torch.cat([diagonal.means, diagonal.sh.flatten(1), by_scale, by_opacity[:, None]], dim=1)
    return np.asarray(columns.numpy())
