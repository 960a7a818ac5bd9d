"""The numbers of the table of scorers: how well each predictor agrees with the true SSIM on held-out scenes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.iqa.held_out.held_out_record import HeldOutScores, Scored
from metrics.definitions import Metric
from metrics.ranking import FEWEST, kendall, mean_within, spearman
from metrics.statistics import ENOUGH_FOR_SPREAD

FloatArray = npt.NDArray[np.float64]

PIXELS = (
    Metric("pixel_error", "pixel L1", False, 3, "", "mean absolute error of predicted maps over all pixels"),
    Metric("pixel_pearson", "pixel r", True, 2, "", "Pearson's correlation of predicted and true maps over all pixels"),
)
"""What only a predictor of maps has."""

IMAGES = (
    Metric("pearson", "image r", True, 2, "", "Pearson's correlation of scores and SSIM over all renderings"),
    Metric("spearman", "Spearman", True, 2, "", "Spearman's rho of scores and SSIM over all renderings"),
    Metric("kendall", "Kendall", True, 2, "", "Kendall's tau-b of scores and SSIM over all renderings"),
)
"""Agreement over all renderings of a scene: much of it tells an early reconstruction from a late one."""

WITHIN = Metric("within", "within a moment", True, 2, "", "Spearman's rho among the candidates of one moment, mean")
"""What a choice depends on."""

WITHIN_KENDALL = Metric("within_kendall", "Kendall within a moment", True, 2, "", "Kendall's tau-b likewise")
"""The same in another statistic; the csv file has it."""

METRICS = (*PIXELS, *IMAGES, WITHIN, WITHIN_KENDALL)
"""All of them, in the order of the csv file."""


@dataclass(frozen=True)
class Agreement:
    """One number of one predictor.

    Attributes:
        mean: over scenes; None where a scene has none.
        error: its standard error over scenes; None of fewer than three.
        scenes: how many there are.
    """

    mean: float | None
    error: float | None
    scenes: int


def scene_numbers(record: HeldOutScores, scored: Scored) -> dict[str, float | None]:
    """Return every number of a predictor on one scene, by the metric's identifier; None where it is undefined."""
    found: dict[str, float | None] = {"pixel_error": scored.pixel_error, "pixel_pearson": scored.pixel_pearson}
    if scored.scores is None:
        return {metric.identifier: None for metric in METRICS}
    scores = np.array(scored.scores) * (1.0 if scored.worst == "lowest" else -1.0)
    truth, moment = np.array(record.ssim), np.array(record.moment)
    rows = np.array(record.candidate)
    found["pearson"] = _pearson(scores, truth)
    found["spearman"] = spearman(scores, truth).value
    found["kendall"] = kendall(scores, truth).value
    found["within"] = mean_within(spearman, scores[rows], truth[rows], moment[rows]).value
    found["within_kendall"] = mean_within(kendall, scores[rows], truth[rows], moment[rows]).value
    return found


def moments_without_order(record: HeldOutScores, scored: Scored) -> tuple[int, int]:
    """Return at how many moments a predictor gives all candidates one score, and how many have an order at all.

    Its mean within moments is one over the others, which are not those of another predictor.
    """
    if scored.scores is None:
        return 0, 0
    scores, truth = np.array(scored.scores), np.array(record.ssim)
    moment, rows = np.array(record.moment), np.array(record.candidate)
    places = [rows & (moment == each) for each in np.unique(moment)]
    ordered = [place for place in places if place.sum() >= FEWEST and np.ptp(truth[place]) > 0.0]
    return sum(np.ptp(scores[place]) == 0.0 for place in ordered), len(ordered)


def over_scenes(values: Sequence[float | None]) -> Agreement:
    """Return the mean over scenes of one number, with its standard error."""
    defined = np.array([value for value in values if value is not None])
    if not len(values) or len(defined) < len(values):
        return Agreement(None, None, len(values))
    error = float(defined.std(ddof=1) / np.sqrt(len(defined))) if len(defined) >= ENOUGH_FOR_SPREAD else None
    return Agreement(float(defined.mean()), error, len(defined))


def agreements(records: Sequence[HeldOutScores]) -> Mapping[str, Mapping[str, Agreement]]:
    """Return every number of every predictor over the scenes of ``records``, by predictor and metric."""
    numbers: dict[str, list[dict[str, float | None]]] = {}
    for record in records:
        for scored in record.scored:
            numbers.setdefault(scored.identifier, []).append(scene_numbers(record, scored))
    return {
        predictor: {metric.identifier: over_scenes([each[metric.identifier] for each in scenes]) for metric in METRICS}
        for predictor, scenes in numbers.items()
    }


def _pearson(scores: FloatArray, truth: FloatArray) -> float | None:
    if np.ptp(scores) == 0.0 or np.ptp(truth) == 0.0:
        return None
    return float(np.corrcoef(scores, truth)[0, 1])
