"""Fisher information of the parameters that are optimised: the rasteriser's, taken through the activations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import torch
from torch import Tensor

from avs.rasterizer.fisher_diagonal import fisher_diagonal
from avs.representations.capabilities import FisherInformation
from avs.representations.gaussians.parameters import Parameters
from avs.scene.cameras import Cameras
from avs.system.errors import UserError

EXPONENTS = {"once": 1, "squared": 2}
"""Power of the derivative of an activation, by chain.

FisherRF squares inside its rasteriser, with respect to the activated scale s and opacity o, and lets autograd multiply
once: H s and H o (1 - o). The diagonal of the Gauss-Newton matrix has these factors squared.
"""

GROUPS = ("means", "f_dc", "f_rest", "scales", "opacities", "quats")
"""Groups of parameters, in the order of their columns: 3, 3, 3 (d + 1)^2 - 3, 3, 1 and 4 for harmonics of degree d."""


def parameter_fisher(
    parameters: Parameters,
    cameras: Cameras,
    sh_degree: int,
    background: tuple[float, float, float],
    chain: str,
    groups: Sequence[str],
) -> Iterator[FisherInformation]:
    """Yield the exact information, camera by camera, with the columns of ``GROUPS`` that ``groups`` names.

    It is computed on the CPU, on copies of the parameters where these are elsewhere. Quaternions are those that are
    optimised, of any length; harmonics above ``sh_degree``, which have none, get no columns.

    Args:
        parameters: of n Gaussians.
        cameras: of any sizes.
        sh_degree: degree d in use.
        background: colour behind the Gaussians.
        chain: ``once`` or ``squared``, see ``EXPONENTS``.
        groups: names of ``GROUPS``, in any order.

    Raises:
        UserError: the chain or a group is not known.
    """
    check_options(chain, groups)
    values = activated({name: parameter.detach().cpu() for name, parameter in parameters.items()})
    behind = torch.tensor(background, dtype=torch.float32)
    return (_of_camera(values, cameras[index], sh_degree, behind, chain, groups) for index in range(len(cameras)))


def check_options(chain: str, groups: Sequence[str]) -> None:
    """Raise a UserError if ``chain`` or one of ``groups`` is not known."""
    if chain not in EXPONENTS:
        raise UserError(f"chain {chain!r}", "is not known", f"choose one of {', '.join(EXPONENTS)}")
    for name in groups:
        if name not in GROUPS:
            raise UserError(f"parameters {name!r}", "are not known", f"choose among {', '.join(GROUPS)}")


def activated(parameters: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Return the tensors as the rasteriser takes them: exponential scales, sigmoid opacities, the others unchanged."""
    changed = {"scales": parameters["scales"].exp(), "opacities": parameters["opacities"].sigmoid()}
    return {**parameters, **changed}


def as_columns(
    squares: Mapping[str, Tensor], scales: Tensor, opacities: Tensor, chain: str, groups: Sequence[str]
) -> Tensor:
    """Return ``[m, columns]`` of the groups asked for, taken through the activations.

    Args:
        squares: sums of squared derivatives by activated ``means`` ``[m, 3]``, ``sh`` ``[m, (d + 1)^2, 3]``,
            ``scales`` ``[m, 3]``, ``opacities`` ``[m]`` and, if asked for, ``quats`` ``[m, 4]``.
        scales: activated ``[m, 3]``.
        opacities: activated ``[m]``.
        chain: as in ``parameter_fisher``.
        groups: as in ``parameter_fisher``.
    """
    exponent = EXPONENTS[chain]
    columns = {
        "means": lambda: squares["means"],
        "f_dc": lambda: squares["sh"][:, 0],
        "f_rest": lambda: squares["sh"][:, 1:].flatten(1),
        "scales": lambda: squares["scales"] * scales**exponent,
        "opacities": lambda: (squares["opacities"] * (opacities * (1 - opacities)) ** exponent)[:, None],
        "quats": lambda: squares["quats"],
    }
    return torch.cat([columns[name]() for name in GROUPS if name in groups], dim=1)


def _of_camera(
    values: Mapping[str, Tensor],
    camera: Cameras,
    sh_degree: int,
    background: Tensor,
    chain: str,
    groups: Sequence[str],
) -> FisherInformation:
    """Return one camera's information; ``values`` are after activation."""
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
        rotations="quats" in groups,
    )
    rows = diagonal.rows
    columns = as_columns(vars(diagonal), values["scales"][rows], values["opacities"][rows], chain, groups)
    return FisherInformation(rows.numpy(), columns.numpy(), len(values["means"]))
