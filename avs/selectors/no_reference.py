"""No-reference image quality metrics: the candidate whose rendering looks worst by itself. All through pyiqa.

A further metric of pyiqa is one more row of ``_METRICS``.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from pydantic import Field, PositiveInt

from avs.representations.base import FloatImages
from avs.resizing import ResizeSettings
from avs.selectors.base import Method, Resources, Selection, Settings, State, choose, render_candidates

if TYPE_CHECKING:
    from torch import nn


@dataclass(frozen=True)
class _Metric:
    """One metric of pyiqa.

    Attributes:
        name: its name in pyiqa.
        label: the name printed in tables.
        lower_better: pyiqa's direction; a test holds the two together, so that reading it needs no import of pyiqa.
        publication: where it was published.
        black: the score of a rendering without a single positive pixel, where pyiqa gives NaN; None where it does not.
    """

    name: str
    label: str
    lower_better: bool
    publication: str
    black: float | None = None


_METRICS = (
    _Metric(
        "piqe",
        "PIQE",
        lower_better=True,
        publication="Venkatanath et al., NCC 2015",
        # pyiqa divides an image by its maximum. Any other image of one colour gets 100, the worst of PIQE's range.
        black=100.0,
    ),
)


class NoReferenceSettings(Settings):
    """Settings of a no-reference metric."""

    resize: ResizeSettings = Field(default=ResizeSettings(), description="size of the images that the metric sees")
    batch: PositiveInt = Field(default=8, description="candidates rendered and scored at once; bounds the memory")


class NoReferenceSelector:
    """Worst quality by one metric, in the direction that pyiqa gives it."""

    def __init__(self, metric: _Metric, settings: NoReferenceSettings, resources: Resources) -> None:
        """Make the metric."""
        self._metric = metric
        self._settings = settings
        self._device = resources.device
        self._network = _create(metric.name, resources.device)

    def select(self, state: State, k: int) -> Selection:
        """Return the ``k`` candidates of the worst quality; of the representation only ``render`` is used."""
        scores = np.empty(len(state.candidates))
        render_seconds = 0.0
        for rows, renderings, seconds in render_candidates(state, self._settings.batch):
            render_seconds += seconds
            scores[rows] = self.score(renderings)
        return Selection(choose(scores, k, self._metric.lower_better), scores, render_seconds)

    def score(self, images: FloatImages) -> npt.NDArray[np.float64]:
        """Return ``[n]`` scores of ``[n, height, width, 3]`` images in 0..1.

        Raises:
            ValueError: the metric gives no number for an image that is not black.
        """
        import torch

        from avs.resizing import resized, to_tensor

        with torch.inference_mode():
            # antialiased bilinear resizing can leave 0..1 by a rounding error, which pyiqa refuses
            batch = resized(to_tensor(images, self._device), self._settings.resize).clamp(0.0, 1.0)
            scores: npt.NDArray[np.float64] = self._network(batch).double().cpu().numpy().reshape(len(images))
        if self._metric.black is not None:
            scores[(images <= 0).all(axis=(1, 2, 3))] = self._metric.black
        if not np.isfinite(scores).all():
            raise ValueError(f"{self._metric.name} gives no number for {np.count_nonzero(~np.isfinite(scores))} images")
        return scores


def _create(name: str, device: str) -> nn.Module:
    """Return a metric of pyiqa; PIQE has no weights, so nothing is fetched."""
    from avs.compatibility import prepare_torchvision

    prepare_torchvision()
    import pyiqa
    import torch

    network: nn.Module = pyiqa.create_metric(name, device=torch.device(device))
    return network


METHODS = {
    metric.name: Method(
        label=metric.label,
        group="2D-based",
        source=f"{metric.publication}, as pyiqa computes it, on the rendering resized as the settings say.",
        higher_is_worse=metric.lower_better,
        build=functools.partial(NoReferenceSelector, metric),
        settings=NoReferenceSettings,
    )
    for metric in _METRICS
}
