"""Makes a metric of pyiqa from local files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from avs import weights
from avs.compatibility import prepare_torchvision

if TYPE_CHECKING:
    from torch import Tensor

Score = Callable[["Tensor"], "Tensor"]
"""Maps RGB images ``[n, 3, height, width]`` in 0..1 to ``[n]`` scores; NaN where the metric has nothing to measure."""


def build(metric: str, name: str | None, device: str, parameters: Path | None = None) -> Score:
    """Return a metric of pyiqa.

    Args:
        metric: its name in pyiqa.
        name: its published weights in the manifest of ``avs.weights``, or None for a metric without any.
        device: ``cpu`` or ``cuda``.
        parameters: a file of ``avs.quality.niqe_fit`` that NIQE takes instead of the published parameters.

    Raises:
        UserError: the weights are absent, damaged, hold objects, or are those of another metric.
    """
    prepare_torchvision()
    if metric == "niqe":
        from avs.quality.niqe import NIQE, read_published
        from avs.quality.niqe_fit import read_refitted

        return NIQE(read_published(weights.verified("niqe")) if parameters is None else read_refitted(parameters))
    if metric == "brisque":
        from avs.quality.brisque import BRISQUE, read_support_vectors

        return BRISQUE(*read_support_vectors(weights.verified("brisque")))
    from avs.quality.networks import build_metric

    return build_metric(metric, name, device)
