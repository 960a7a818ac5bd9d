"""FisherRF: the candidate that carries the most Fisher information about the parameters (arXiv 2311.17874)."""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from avs.representations.base import HasFisherDiagonal, capability
from avs.selectors.base import Method, Resources, Selection, Settings, State, choose


class FisherSettings(Settings):
    """Settings of FisherRF."""

    chain: Literal["once", "squared"] = Field(
        default="once",
        description="how an activation's derivative enters the square: once, as in the published code, or squared",
    )
    regularisation: float = Field(
        default=1e-6, gt=0, description="lambda, added to the information of the captured views before dividing by it"
    )


def information_gain(
    candidate: npt.NDArray[np.float32], captured: npt.NDArray[np.float64], regularisation: float
) -> float:
    """Return the sum over parameters of candidate / (captured + lambda): FisherRF's trace criterion.

    Both arrays are ``[primitives, parameters]``, non-negative. The sum runs in float64: with lambda = 1e-6 parameters
    that no captured view has seen weigh a million times their information.
    """
    return float((candidate / (captured + regularisation)).sum(dtype=np.float64))


class FisherSelector:
    """Largest information gain against the captured views, with diagonal Fisher matrices."""

    def __init__(self, settings: FisherSettings, resources: Resources) -> None:
        """Keep the settings; no resources are needed."""
        self._settings = settings

    def select(self, state: State, k: int) -> Selection:
        """Return the ``k`` candidates of the largest gain; the captured views are summed anew each time.

        Raises:
            UserError: the representation cannot compute the Fisher information.
        """
        fisher = capability(state.representation, HasFisherDiagonal, "fisherrf").fisher_diagonal
        diagonals = fisher(state.captured.cameras, self._settings.chain)
        captured = next(diagonals).astype(np.float64)
        for diagonal in diagonals:
            captured += diagonal
        scores = np.array(
            [
                information_gain(diagonal, captured, self._settings.regularisation)
                for diagonal in fisher(state.candidates, self._settings.chain)
            ]
        )
        return Selection(choose(scores, k, higher_is_worse=True), scores)


METHODS = {
    "fisherrf": Method(
        label="FisherRF",
        group="3D-based",
        source=(
            "Jiang et al., arXiv 2311.17874, and its code at commit b747328: exact diagonal, squared per pixel after "
            "the channel sum, rotation left out, lambda 1e-6. Two deviations: the reconstruction goes on after a "
            "selection unless refit is reinit, and the view-direction term reads the right harmonics (the published "
            "kernel's offset is off)."
        ),
        higher_is_worse=True,
        build=FisherSelector,
        settings=FisherSettings,
    )
}
