"""The numbers of the ranking table: do a method's scores order the candidates as the truth does?"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from avs.nvs.record import Episode, Step
from avs.report.collect import Cell, Episodes
from avs.report.tables.episode_gaps import missing_row
from avs.selection.contract import Direction
from avs.system.reasons import Reason
from metrics.definitions import Metric
from metrics.ranking import Correlation, kendall, spearman
from metrics.statistics import spread_of, summarise

FloatArray = npt.NDArray[np.float64]
Target = Literal["ssim", "psnr", "gain"]

STATISTICS = {"spearman": spearman, "kendall": kendall}
"""Rank correlations by identifier."""

SETTINGS: dict[Target, str] = {"ssim": "image_every", "psnr": "image_every", "gain": "gain_every"}
"""The truths by identifier, and the setting of ``protocol.truth`` that has them measured."""

_NAMES: dict[Target, str] = {"ssim": "SSIM", "psnr": "PSNR", "gain": "gain"}


@dataclass(frozen=True)
class Correlated:
    """One correlation: which truth, which statistic, and how the column is printed."""

    target: Target
    statistic: str
    metric: Metric


COLUMNS = tuple(
    Correlated(
        target,
        statistic,
        Metric(
            identifier=f"{target}_{statistic}",
            name=f"{_NAMES[target]}, {statistic.capitalize()}",
            higher_is_better=True,
            decimals=2,
            unit="",
            description=f"rank correlation of a method's scores and the true {_NAMES[target]}",
        ),
    )
    for target in SETTINGS
    for statistic in STATISTICS
)
"""The columns, in order."""


@dataclass(frozen=True)
class Ranking:
    """One correlation of one method.

    Attributes:
        mean: mean over seeds of the mean over scenes of the mean over selections, or None with a reason in ``missing``.
        spread: standard deviation over seeds of the mean over scenes or, with fewer than three seeds, over scenes of
            the mean over seeds; None where there are not three of either.
        over: what the spread is over: ``seeds``, ``scenes``, or empty where there is no spread.
        scenes: number of scenes in the mean.
        seeds: number of seeds in the mean.
        steps: number of selections in the mean, over all scenes and seeds.
        left_out: selections whose correlation is undefined, by reason.
        missing: why there is no mean, or None.
    """

    mean: float | None = None
    spread: float | None = None
    over: str = ""
    scenes: int = 0
    seeds: int = 0
    steps: int = 0
    left_out: Mapping[str, int] = field(default_factory=dict)
    missing: Reason | None = None


def summarise_ranking(
    episodes: Episodes, methods: Sequence[str], absent: Mapping[str, Reason]
) -> dict[str, dict[str, Ranking]]:
    """Compute every correlation, by identifier of the method and of the column.

    Args:
        episodes: the episodes of one data set.
        methods: identifiers of the rows; those without numbers have the reason.
        absent: why a method could not run, by identifier.
    """
    return {
        method: {column.metric.identifier: _ranking(episodes, method, column, absent) for column in COLUMNS}
        for method in methods
    }


def oriented(step: Step, chooses: Direction, target: Target) -> tuple[FloatArray, FloatArray] | None:
    """Return the scores and the truth of the candidates that have both, each turned so that the first choice is high.

    A method takes the lowest or the highest score first, as ``chooses`` tells. The truth has the lowest SSIM or PSNR
    first, as the paper's hypothesis says, and the highest gain.

    Returns:
        Two arrays ``[n]``, or None if the selection has no scores or the truth was not measured at it.
    """
    truth = None if step.truth is None else getattr(step.truth, target)
    if step.scores is None or truth is None:
        return None
    both = [pair for pair in zip(step.scores, truth, strict=True) if None not in pair]
    values = np.array(both, dtype=np.float64).reshape(-1, 2)
    return values[:, 0] * (1 if chooses == "highest" else -1), values[:, 1] * (1 if target == "gain" else -1)


def _ranking(episodes: Episodes, method: str, column: Correlated, absent: Mapping[str, Reason]) -> Ranking:
    reason = missing_row(episodes, method, absent)
    if reason is not None:
        return Ranking(missing=reason)
    seeds, scenes = episodes.complete_seeds(method), episodes.scenes
    cells: dict[Cell, list[Correlation]] = {
        (scene, seed): _correlations(episodes.cells[method][scene, seed], column) for scene in scenes for seed in seeds
    }
    found = {
        cell: [each.value for each in correlations if each.value is not None] for cell, correlations in cells.items()
    }
    for cell, values in found.items():
        if not values:
            return Ranking(missing=_undefined(episodes.cells[method][cell], cells[cell], column))
    means = np.array([[np.mean(found[scene, seed]) for scene in scenes] for seed in seeds])
    summary = summarise(means)
    spread, over = summary.spread, "seeds"
    if spread is None:
        spread, over = spread_of(means.mean(axis=0)), "scenes"
    left_out = Counter(each.reason for correlations in cells.values() for each in correlations if each.reason)
    steps = sum(map(len, found.values()))
    over = "" if spread is None else over
    return Ranking(summary.mean, spread, over, len(scenes), len(seeds), steps, dict(sorted(left_out.items())))


def _correlations(episode: Episode, column: Correlated) -> list[Correlation]:
    """Return the correlation at every selection where scores and truth are recorded."""
    pairs = (oriented(step, episode.chooses, column.target) for step in episode.steps)
    return [STATISTICS[column.statistic](*pair) for pair in pairs if pair is not None]


def _undefined(episode: Episode, correlations: Sequence[Correlation], column: Correlated) -> Reason:
    """Say why an episode has no correlation at all."""
    if all(step.scores is None for step in episode.steps):
        return Reason(cause="the method records no scores")
    if not correlations:
        return Reason(cause=f"not measured (protocol.truth.{SETTINGS[column.target]})")
    reasons = sorted({each.reason for each in correlations if each.reason is not None})
    return Reason(cause=f"{episode.scene}: {', '.join(reasons)}")
