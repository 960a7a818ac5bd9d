"""FisherRF: the candidate that carries the most Fisher information about the parameters (arXiv 2311.17874)."""

from __future__ import annotations

import functools

import numpy as np
import numpy.typing as npt

from avs.selection.contract import Batches, Method, Resources
from avs.selection.information import InformationSelector, InformationSettings


def trace_gain(candidate: npt.NDArray[np.float32], captured: npt.NDArray[np.float64], regularisation: float) -> float:
    """Return the sum over parameters of candidate / (captured + lambda), FisherRF's expected information gain.

    It runs in float64: with lambda = 1e-6 parameters that no captured view has seen weigh a million times their
    information.
    """
    return float((candidate / (captured + regularisation)).sum())


def _build(method: str, settings: InformationSettings, resources: Resources) -> InformationSelector:
    """Make the selector; it needs no resources."""
    return InformationSelector(method, trace_gain, settings)


_SOURCE = (
    "Jiang et al., arXiv 2311.17874, and its code at commit b747328: diagonal information, squared per pixel after the "
    "channel sum, rotation left out, lambda 1e-6. Two deviations: the reconstruction goes on after a selection unless "
    "refit is reinit, and the view-direction term reads the right harmonics (the published kernel's offset is off)."
)

METHODS = {
    "fisherrf": Method(
        label="FisherRF",
        group="3D-based",
        source=_SOURCE,
        chooses="highest",
        build=functools.partial(_build, "fisherrf"),
        settings=InformationSettings,
        needs=("fisher_diagonal",),
    ),
    "fisherrf4": Method(
        label="FisherRF4",
        group="3D-based",
        source=(
            f"{_SOURCE} Four views a step, at the moments of its script, each chosen against the captured views and "
            "those chosen before it. Lambda is FisherRF's, so that the two rows differ in the batch alone; the "
            "published script for batches has 2 (setting regularisation)."
        ),
        chooses="highest",
        batches=Batches(views_per_step=4, additions=(1200, 3600, 7200, 12000)),
        build=functools.partial(_build, "fisherrf4"),
        settings=InformationSettings,
        needs=("fisher_diagonal",),
    ),
}
