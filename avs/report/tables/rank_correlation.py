"""The ranking table before it takes a form: does a method's score order the candidates as the truth does?"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from avs.nvs.record import Episode, Step
from avs.report.collect import Cell, Episodes
from avs.report.tables.summary import Entry, Row, Table, missing_episodes, printed_as
from avs.selection.contract import Direction
from avs.system.reasons import Reason
from metrics.definitions import Metric
from metrics.ranking import Correlation, kendall, spearman
from metrics.statistics import summarise

FloatArray = npt.NDArray[np.float64]
Target = Literal["ssim", "psnr", "gain"]

STATISTICS = {"spearman": spearman, "kendall": kendall}
"""Rank correlations by identifier."""

SETTINGS: dict[Target, str] = {"ssim": "image_every", "psnr": "image_every", "gain": "gain_every"}
"""The truths by identifier, and the setting of ``protocol.truth`` that has them measured."""

_NAMES: dict[Target, str] = {"ssim": "SSIM", "psnr": "PSNR", "gain": "gain"}


@dataclass(frozen=True)
class Column:
    """One correlation: which truth, which statistic, and how the column is printed."""

    target: Target
    statistic: str
    metric: Metric


COLUMNS = tuple(
    Column(
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
class Detail:
    """What a correlation is a mean of.

    Attributes:
        steps: number of selections that entered, over all scenes and seeds.
        over: what the spread is over: ``seeds``, ``scenes``, or empty where there is no spread.
        left_out: selections whose correlation is undefined, by reason.
    """

    steps: int
    over: str
    left_out: dict[str, int]


@dataclass(frozen=True)
class Ranking:
    """The ranking table of one data set: its numbers, and a detail for each (method, column's identifier)."""

    table: Table
    details: dict[tuple[str, str], Detail]


def summarise_ranking(episodes: Episodes, methods: Sequence[str], absent: Mapping[str, Reason]) -> Ranking:
    """Compute every correlation: mean over selections, then over scenes, then over seeds.

    Args:
        episodes: the episodes of one data set.
        methods: identifiers of the rows, in order; those without numbers keep their row, with the reason.
        absent: why a method could not run, by identifier.
    """
    rows, details = [], {}
    for method in methods:
        entries = {}
        for column in COLUMNS:
            key = column.metric.identifier
            entries[key], details[method, key] = _entry(episodes, method, column, absent)
        rows.append(Row(method, *printed_as(episodes, method), entries))
    metrics = [column.metric for column in COLUMNS]
    return Ranking(Table(episodes, metrics, rows, reference=None, has_published=False), details)


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


def _entry(episodes: Episodes, method: str, column: Column, absent: Mapping[str, Reason]) -> tuple[Entry, Detail]:
    reason = missing_episodes(episodes, method, absent)
    if reason is not None:
        return _without(reason)
    seeds, scenes = episodes.complete_seeds(method), episodes.scenes
    cells: dict[Cell, list[Correlation]] = {
        (scene, seed): _correlations(episodes.cells[method][scene, seed], column) for scene in scenes for seed in seeds
    }
    found = {
        cell: [each.value for each in correlations if each.value is not None] for cell, correlations in cells.items()
    }
    for (scene, seed), values in found.items():
        if not values:
            return _without(_undefined(episodes.cells[method][scene, seed], cells[scene, seed], column))
    means = np.array([[np.mean(found[scene, seed]) for scene in scenes] for seed in seeds])
    summary = summarise(means)
    spread, over = summary.spread, "seeds" if len(seeds) > 1 else ""
    if len(seeds) == 1 and len(scenes) > 1:
        spread, over = float(means[0].std(ddof=1)), "scenes"
    left_out = Counter(each.reason for correlations in cells.values() for each in correlations if each.reason)
    detail = Detail(sum(map(len, found.values())), over, dict(sorted(left_out.items())))
    return Entry(summary.mean, spread, len(scenes), len(seeds), None), detail


def _correlations(episode: Episode, column: Column) -> list[Correlation]:
    """Return the correlation at every selection where scores and truth are recorded."""
    pairs = (oriented(step, episode.chooses, column.target) for step in episode.steps)
    return [STATISTICS[column.statistic](*pair) for pair in pairs if pair is not None]


def _undefined(episode: Episode, correlations: Sequence[Correlation], column: Column) -> Reason:
    """Say why an episode has no correlation at all."""
    if all(step.scores is None for step in episode.steps):
        return Reason(cause="the method records no scores")
    if not correlations:
        return Reason(cause=f"not measured (protocol.truth.{SETTINGS[column.target]})")
    reasons = sorted({each.reason for each in correlations if each.reason is not None})
    return Reason(cause=f"{episode.scene}: {', '.join(reasons)}")


def _without(reason: Reason) -> tuple[Entry, Detail]:
    return Entry(None, None, 0, 0, None, missing=reason), Detail(0, "", {})
