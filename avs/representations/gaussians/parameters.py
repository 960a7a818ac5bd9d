"""The trainable tensors of a set of Gaussians."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from torch.nn import Parameter

from avs.representations.gaussians.initialization import DARKEST, SH_DEGREE_0, PointCloud, initial_scales
from avs.system.errors import UserError

Parameters = dict[str, Parameter]
"""The tensors, by the names that gsplat's strategies expect:

- ``means`` ``[n, 3]``: positions, world coordinates.
- ``scales`` ``[n, 3]``: logarithms of the standard deviations along the axes.
- ``quats`` ``[n, 4]``: rotations as (w, x, y, z), of any length but 0.
- ``opacities`` ``[n]``: logits.
- ``sh`` ``[n, (degree + 1)^2, 3]``: spherical harmonics of the colour minus 0.5.
"""

NAMES = ("means", "scales", "quats", "opacities", "sh")


@dataclass(frozen=True)
class PrimitiveParameter:
    """A number more that each Gaussian has and the optimisation learns.

    It follows the Gaussians as their other parameters do: copied when one is cloned or split, and removed with it.

    Attributes:
        initial: its value at the start.
        learning_rate: of Adam; None is the rate of the Gaussians' opacities.
    """

    initial: float
    learning_rate: float | None = None


def create_parameters(cloud: PointCloud, opacity: float, sh_degree: int, device: torch.device) -> Parameters:
    """Return Gaussians at the points of ``cloud``: isotropic, unrotated, of one opacity and the points' colours.

    Colours below ``DARKEST`` become that.
    """
    count = len(cloud.positions)
    scales = np.log(initial_scales(cloud.positions))
    harmonics = np.zeros((count, (sh_degree + 1) ** 2, 3))
    harmonics[:, 0] = (np.maximum(cloud.colors, DARKEST) - 0.5) / SH_DEGREE_0
    values = {
        "means": cloud.positions,
        "scales": np.repeat(scales[:, None], 3, axis=1),
        "quats": np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
        "opacities": np.full(count, math.log(opacity / (1 - opacity))),
        "sh": harmonics,
    }
    return {name: Parameter(torch.tensor(values[name], dtype=torch.float32, device=device)) for name in NAMES}


def extend_parameters(parameters: Parameters, extra: Mapping[str, PrimitiveParameter]) -> None:
    """Add one number ``[n]`` per Gaussian for each of ``extra``, at its initial value, to ``parameters`` in place.

    Raises:
        ValueError: a name is taken.
    """
    means = parameters["means"]
    for name, one in extra.items():
        if name in parameters:
            raise ValueError(f"parameter {name} is there already")
        parameters[name] = Parameter(torch.full((len(means),), one.initial, device=means.device))


def check_finite(parameters: Parameters, iteration: int) -> None:
    """Refuse Gaussians that cannot be optimised further.

    Args:
        parameters: their tensors.
        iteration: optimisation steps done so far, for the message.

    Raises:
        UserError: parameters stopped being finite, or every Gaussian was pruned.
    """
    broken = [name for name, values in parameters.items() if not bool(torch.isfinite(values).all())]
    fault = f"{', '.join(broken)} stopped being finite" if broken else "every Gaussian was pruned"
    if broken or not len(parameters["means"]):
        remedy = "lower the learning rates or check the scene's cameras and points"
        raise UserError(f"reconstruction at step {iteration}", fault, remedy)
