"""FisherRF: the candidate that carries the most Fisher information about the parameters (arXiv 2311.17874)."""

from __future__ import annotations

import functools

import numpy as np
import numpy.typing as npt

from avs.selection.contract import OWN_SCHEDULE, Batches, Method, Resources
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
    "refit is reinit, and the view-direction term reads the right harmonics (the published kernel's offset is off). "
    "Lambda is a constant at any image size, as in the code (docs/reconstruction-study.md)."
)

_BATCH = (
    f"{_SOURCE} Four views are chosen together, each against the captured views and those chosen before it. Lambda is "
    "FisherRF's, so that the rows differ in the batch alone; the published script for batches has 2 (setting "
    "regularisation)."
)


def _method(
    identifier: str, label: str, source: str, group: str = "3D-based", batches: Batches | None = None
) -> Method:
    return Method(
        label=label,
        group=group,
        source=source,
        chooses="highest",
        batches=batches,
        build=functools.partial(_build, identifier),
        settings=InformationSettings,
        needs=("fisher_diagonal",),
    )


METHODS = {
    "fisherrf": _method("fisherrf", "FisherRF", _SOURCE),
    "fisherrf4": _method(
        "fisherrf4",
        "FisherRF4",
        f"{_BATCH} They are captured one by one, when every other method's views are: a deviation, by which the rows "
        "of a table differ in the choice alone.",
        batches=Batches(views=4),
    ),
    "fisherrf4-released": _method(
        "fisherrf4-released",
        "FisherRF4 (released schedule)",
        f"{_BATCH} Each four are captured at once, at the moments of its script: the method as released.",
        group=OWN_SCHEDULE,
        batches=Batches(views=4, additions=(1200, 3600, 7200, 12000)),
    ),
}
