"""Makes a metric of pyiqa from local files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from avs.system import weights
from avs.system.compatibility import prepare_torchvision
from avs.system.weights.cache import COMMAND

if TYPE_CHECKING:
    from torch import Tensor

    from avs.iqa.no_reference.niqe_fit import FittedParameters

Score = Callable[["Tensor"], "Tensor"]
"""Maps RGB images ``[n, 3, height, width]`` in 0..1 to ``[n]`` scores; NaN where the metric has nothing to measure."""


def build(metric: str, name: str | None, device: str, path: Path | None = None) -> Score:
    """Return a metric of pyiqa.

    Args:
        metric: its name in pyiqa.
        name: its published weights in the manifest of ``avs.system.weights``, or None for a metric without any.
        device: ``cpu`` or ``cuda``.
        path: the local file of the weights; None looks for it.

    Raises:
        UserError: the weights are absent, damaged, hold objects, or are those of another metric.
    """
    prepare_torchvision()
    path = None if name is None else weights.verified(name, path)
    if path is None:
        from avs.iqa.no_reference.pyiqa_networks import build_plain

        return build_plain(metric, device)
    if metric == "niqe":
        from avs.iqa.no_reference.niqe import NIQE, read_published

        return NIQE(read_published(path))
    if metric == "brisque":
        from avs.iqa.no_reference.brisque import BRISQUE, read_support_vectors

        return BRISQUE(*read_support_vectors(path))
    from avs.iqa.no_reference.pyiqa_networks import build_network

    return build_network(metric, path, device, f"{COMMAND} {name}")


def fitted_niqe(fitted: FittedParameters) -> Score:
    """Return NIQE with parameters that were fitted here."""
    prepare_torchvision()
    from avs.iqa.no_reference.niqe import NIQE

    return NIQE(fitted.gaussian)
