"""No-reference image quality metrics: the candidate whose rendering looks worst by itself. All through pyiqa.

A further metric of pyiqa is one more row of ``_METRICS``, and an entry of the weights' manifest if it needs any.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from pydantic import Field, PositiveInt

from avs.iqa.no_reference.niqe_settings import FitSettings, PatchSettings
from avs.iqa.resizing import ResizeSettings
from avs.representations.base import FloatImages
from avs.selection.batched_rendering import render_candidates
from avs.selection.contract import Method, Resources, Settings, State
from avs.system.errors import UserError

if TYPE_CHECKING:
    from avs.iqa.no_reference.pyiqa_metrics import Score


# On a CPU so many pixels are scored at once. Their intermediate images stay in the cache: eight images of 518x345 take
# a third longer in one pass than two by two, but eight of 192x128 half as long as one by one.
_PIXELS = 400_000


@dataclass(frozen=True)
class _Metric:
    """One metric of pyiqa.

    Attributes:
        name: its name in pyiqa.
        label: the name printed in tables.
        lower_better: pyiqa's direction; a test holds the two together, so that reading it needs no import of pyiqa.
        publication: where it was published.
        weights: its published weights in the manifest of ``avs.system.weights``, or None.
        nothing: the score of a rendering in which the metric finds nothing to measure; None where that cannot be.
    """

    name: str
    label: str
    lower_better: bool
    publication: str
    weights: str | None = None
    nothing: float | None = None


_METRICS = {
    "brisque": _Metric(
        "brisque",
        "BRISQUE",
        True,
        "Mittal et al., TIP 2012",
        weights="brisque",
        nothing=153.591,  # what the regression gives to features far from every support vector: minus its bias
    ),
    "niqe": _Metric(
        "niqe",
        "NIQE",
        True,
        "Mittal et al., SPL 2013",
        weights="niqe",
        nothing=100.0,  # the end of the range that pyiqa states; NIQE itself has none
    ),
    "piqe": _Metric(
        "piqe",
        "PIQE",
        True,
        "Venkatanath et al., NCC 2015",
        nothing=100.0,  # what any other image of one colour gets, the worst of PIQE's range
    ),
    "nima": _Metric("nima", "NIMA", False, "Talebi and Milanfar, TIP 2018 (InceptionResNetV2, AVA)", weights="nima"),
    "musiq": _Metric("musiq", "MUSIQ", False, "Ke et al., ICCV 2021 (KonIQ-10k)", weights="musiq"),
    "maniqa": _Metric("maniqa", "MANIQA", False, "Yang et al., CVPRW 2022 (KonIQ-10k)", weights="maniqa"),
    "tres": _Metric("tres", "TReS", False, "Golestaneh et al., WACV 2022 (KonIQ-10k)", weights="tres"),
    "topiq": _Metric("topiq_nr", "TOPIQ", False, "Chen et al., TIP 2024 (ResNet-50, KonIQ-10k)", weights="topiq"),
}


class NoReferenceSettings(Settings):
    """Settings of a no-reference metric."""

    resize: ResizeSettings = Field(default=ResizeSettings(), description="size of the images that the metric sees")
    batch: PositiveInt = Field(default=8, description="candidates rendered and scored at once; bounds the memory")


class NIQESettings(NoReferenceSettings):
    """Settings of NIQE."""

    fit: PatchSettings = Field(
        default=PatchSettings(),
        description="the fit to photographs of training scenes, if the published parameters are absent",
    )


class NoReferenceSelector:
    """Worst quality by one metric, in the direction that pyiqa gives it.

    Attributes:
        notes: what a reader of its results should know.
    """

    def __init__(
        self,
        metric: _Metric,
        settings: NoReferenceSettings,
        resources: Resources,
        score: Score | None = None,
        notes: tuple[str, ...] = (),
    ) -> None:
        """Make the metric, unless ``score`` is given.

        Raises:
            UserError: its weights are absent, damaged, hold objects, or are those of another metric.
        """
        if score is None:
            from avs.iqa.no_reference.pyiqa_metrics import build

            score = build(metric.name, metric.weights, resources.device, resources.weights)
        self.notes = notes
        self._metric = metric
        self._settings = settings
        self._device = resources.device
        self._score = score

    def score(self, state: State) -> npt.NDArray[np.float64]:
        """Return the metric of each candidate's rendering, ``[n]``; of the representation only ``render`` is used."""
        scores = np.empty(len(state.candidates))
        for rows, renderings in render_candidates(state, self._settings.batch):
            scores[rows] = self.quality(renderings)
        return scores

    def quality(self, images: FloatImages) -> npt.NDArray[np.float64]:
        """Return ``[n]`` scores of ``[n, height, width, 3]`` images in 0..1.

        Raises:
            ValueError: an image holds numbers that are not finite, or the metric gives none for it.
            UserError: the images are too small for the metric.
        """
        import torch

        from avs.iqa.resizing import resized, to_tensor

        if not np.isfinite(images).all():
            raise ValueError(f"{self._metric.name}: the renderings contain numbers that are not finite")
        with torch.inference_mode():
            # antialiased bilinear resizing can leave 0..1 by a rounding error, which pyiqa refuses
            batch = resized(to_tensor(images, self._device), self._settings.resize).clamp(0.0, 1.0)
            count = len(batch) if self._device != "cpu" else max(1, _PIXELS // (batch.shape[-2] * batch.shape[-1]))
            parts = [self._score(part).double().cpu() for part in torch.split(batch, count)]
        scores: npt.NDArray[np.float64] = torch.cat(parts).numpy()
        if self._metric.nothing is not None:
            scores[np.isnan(scores)] = self._metric.nothing
        if not np.isfinite(scores).all():
            raise ValueError(f"{self._metric.name} gives no number for {np.count_nonzero(~np.isfinite(scores))} images")
        return scores


def _build_niqe(settings: NIQESettings, resources: Resources) -> NoReferenceSelector:
    """Return NIQE with the published parameters, or with those of ``avs niqe_fit`` if they are passed.

    Raises:
        UserError: the parameters are absent, damaged, or were fitted with other settings than the method's.
    """
    path = resources.weights
    if path is None or path.suffix != ".safetensors":
        return NoReferenceSelector(_METRICS["niqe"], settings, resources)
    from avs.iqa.no_reference.niqe_fit import read_fitted
    from avs.iqa.no_reference.pyiqa_metrics import fitted_niqe

    fitted = read_fitted(path)
    if fitted.settings != FitSettings(resize=settings.resize, fit=settings.fit):
        raise UserError(path, "was fitted with other settings than selectors.niqe has", "fit NIQE's parameters again")
    small = f" ({fitted.left_out} others are smaller than it sees them)" if fitted.left_out else ""
    note = f"NIQE: fitted to {fitted.photographs} photographs of training scenes{small}, not the published parameters"
    return NoReferenceSelector(_METRICS["niqe"], settings, resources, fitted_niqe(fitted), (note,))


METHODS = {
    identifier: Method(
        label=metric.label,
        group="2D-based",
        source=(
            f"{metric.publication}, as pyiqa computes it, on the rendering resized as the settings say."
            + ("" if metric.nothing is None else f" A rendering with nothing to measure gets {metric.nothing:g}.")
        ),
        chooses="highest" if metric.lower_better else "lowest",
        build=functools.partial(NoReferenceSelector, metric),
        settings=NoReferenceSettings,
        pretrained=() if metric.weights is None else (metric.weights,),
        assesses_images=True,
    )
    for identifier, metric in _METRICS.items()
}
_NIQE_SOURCE = " Where the published parameters are absent, they are fitted to the run's training scenes."
METHODS["niqe"] = replace(
    METHODS["niqe"],
    source=METHODS["niqe"].source + _NIQE_SOURCE,
    build=_build_niqe,
    settings=NIQESettings,
    fallback="niqe",
)
