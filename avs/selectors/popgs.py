"""POp-GS: optimal experimental design on the Fisher information of the parameters (CVPR 2025, arXiv 2503.07819)."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import numpy.typing as npt
from pydantic import Field

from avs.selection.contract import Method, Resources
from avs.selection.information import InformationSelector, InformationSettings, Parameter


class PopGsSettings(InformationSettings):
    """Settings of POp-GS; all parameters count, as in the paper."""

    parameters: tuple[Parameter, ...] = Field(
        default=get_args(Parameter), min_length=1, description="parameters that count, as for FisherRF"
    )
    criterion: Literal["d", "t"] = Field(
        default="d",
        description="d: growth of the log-determinant of the information; t: decrease of the covariance's trace",
    )


def determinant_gain(
    candidate: npt.NDArray[np.float32], captured: npt.NDArray[np.float64], regularisation: float
) -> float:
    """Return the sum over parameters of log(1 + candidate / (captured + lambda)): D-optimality, p = 0."""
    return float(np.log1p(candidate / (captured + regularisation)).sum())


def variance_gain(
    candidate: npt.NDArray[np.float32], captured: npt.NDArray[np.float64], regularisation: float
) -> float:
    """Return the sum of 1 / (captured + lambda) - 1 / (captured + candidate + lambda): T-optimality, p = 1."""
    before = captured + regularisation
    # as one fraction, without the difference of two large numbers
    return float((candidate / before / (before + candidate)).sum())


_CRITERIA = {"d": determinant_gain, "t": variance_gain}


def _build(settings: PopGsSettings, resources: Resources) -> InformationSelector:
    """Make the selector; it needs no resources."""
    return InformationSelector("popgs", _CRITERIA[settings.criterion], settings)


METHODS = {
    "popgs": Method(
        label="POp-GS",
        group="3D-based",
        source=(
            "Wilson et al., CVPR 2025 (arXiv 2503.07819): D-optimality of the diagonal approximation, greedy for "
            "several views, all parameters, lambda 1e-6; no code is published. Lambda is added to the information, as "
            "the prior information that the text speaks of, where equation 14 adds it to the covariance; the variant "
            "with a block for each Gaussian is not here."
        ),
        chooses="highest",
        build=_build,
        settings=PopGsSettings,
        needs=("fisher_diagonal",),
    )
}
