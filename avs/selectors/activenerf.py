"""ActiveNeRF on 3D Gaussians: the candidate that lowers the learned variance most (arXiv 2209.08546)."""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from avs.representations.base import Representation
from avs.representations.capabilities import capability
from avs.representations.learned_variance import HasLearnedVariance, VarianceLearning, VarianceReduction
from avs.selection.contract import Method, Resources, Settings, State, following


class ActiveNerfSettings(Settings):
    """Settings of ActiveNeRF."""

    form: Literal["clean", "pull_request"] = Field(
        default="clean",
        description="clean: weights alpha_i T_i, as colours have them; pull_request, as in the code proposed to "
        "FisherRF: alpha_i T_(i+1), no gradient from the variance to the geometry, and nothing left after a view where "
        "a pixel's blending ended early. With the floor of 0.1 that form never leaves its first variances: the squares "
        "of a pixel's weights sum up to 0.0902 at most",
    )
    numerator: Literal["squared_weight", "one"] = Field(
        default="squared_weight",
        description="what the variance of a Gaussian counts in the score: its squared weight in the pixel, as in the "
        "code proposed to FisherRF, or 1, as in the original ActiveNeRF",
    )
    learning_rate: float | None = Field(
        default=None,
        gt=0,
        description="learning rate of the log-variances; null: the rate of the opacities",
    )
    constant: float = Field(default=1e-4, ge=0, description="added to the variance of each pixel")
    floor: float = Field(default=0.1, gt=0, description="least variance of a pixel in the loss")


class ActiveNerfSelector:
    """Largest sum over pixels of the variance before a view less that expected after it."""

    def __init__(self, settings: ActiveNerfSettings, resources: Resources) -> None:
        """Keep the settings; no resources are needed."""
        self._settings = settings

    def prepare(self, representation: Representation) -> None:
        """Let the reconstruction learn variances.

        Raises:
            UserError: it cannot.
        """
        settings = self._settings
        rule = VarianceLearning(
            learning_rate=settings.learning_rate,
            constant=settings.constant,
            floor=settings.floor,
            attenuated=settings.form == "pull_request",
        )
        capability(representation, HasLearnedVariance, "activenerf").learn_variance(rule)

    def score(self, state: State) -> npt.NDArray[np.float64]:
        """Return the variance that each candidate's view removes, ``[n]``.

        Raises:
            UserError: the representation has no variance.
        """
        settings = self._settings
        rule = VarianceReduction(
            constant=settings.constant,
            weighted=settings.numerator == "squared_weight",
            saturated=settings.form == "pull_request",
        )
        reduction = capability(state.representation, HasLearnedVariance, "activenerf").variance_reduction
        return reduction(state.candidates, rule)


METHODS = {
    "activenerf": Method(
        label="ActiveNeRF",
        group="3D-based",
        source=(
            "Pan et al., arXiv 2209.08546, carried over to 3D Gaussians as in the code proposed to FisherRF (pull "
            "request 8, commit d8c943b): a log-variance per Gaussian, the likelihood in the place of L1. Two "
            "deviations: unless form is pull_request, weights are those of the colours, the likelihood is "
            "differentiated completely and saturated pixels count as others do; and the reconstruction goes on after a "
            "selection unless refit is reinit."
        ),
        chooses="highest",
        build=ActiveNerfSelector,
        settings=ActiveNerfSettings,
        needs=("learned_variance",),
    ),
    "activenerf-views": following(
        "activenerf",
        "ActiveNeRF's views",
        "The views of ActiveNeRF's episode on Gaussians that learn no variance and follow the common loss: the row of "
        "ActiveNeRF differs from it by its loss, and it differs from the other rows by the choice.",
    ),
}
