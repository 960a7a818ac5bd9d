"""Can coverage that is measured against a cloud be trusted? Its rank correlation with that of the true surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from avs.coverage.episode_coverage import views_of
from avs.nvs.record import Episode
from avs.report.collect import Episodes
from avs.report.collect_coverage import Coverages
from avs.report.document import Listing
from avs.report.formats.numbers import plain
from avs.report.tables.scene_coverage_numbers import coverage_value
from avs.report.tables.view_synthesis_numbers import scene_value
from metrics.ranking import Correlation, kendall, spearman

FIELDS = ("metric", "with", "statistic", "scene", "count", "value", "note")
"""Columns of the csv file of agreements."""

TWINS = {"scr_percent": "true_scr_percent", "f_score": "true_f_score"}
"""Metrics against the reference cloud, and the same against the true surface."""

_DECIMALS = 4

_Pair = tuple[float, float]


@dataclass(frozen=True)
class CoverageAgreement:
    """Rank correlations of one metric with another that it should stand for.

    Attributes:
        metric: identifier.
        other: identifier of the other, or ``psnr``.
        scenes: Spearman's rho over the episodes of each scene, and their number; episodes of the same views count once.
        pooled: the same over the episodes of all scenes, which contains the differences between scenes.
        methods: Kendall's tau-b of the means of the methods that compete.
        compared: number of those methods.
    """

    metric: str
    other: str
    scenes: dict[str, tuple[Correlation, int]]
    pooled: tuple[Correlation, int]
    methods: Correlation
    compared: int

    @property
    def within_scenes(self) -> Correlation:
        """The mean over scenes."""
        values = [each.value for each, _ in self.scenes.values()]
        known = [value for value in values if value is not None]
        if not known or len(known) < len(values):
            return next((each for each, _ in self.scenes.values() if each.value is None), Correlation(None, "no scene"))
        return Correlation(float(np.mean(known)))


def agreements(episodes: Episodes, coverages: Coverages, ranked: Sequence[str]) -> list[CoverageAgreement]:
    """Return how each metric agrees with the truth, where that is known, and with the test PSNR.

    Args:
        episodes: of the data set.
        coverages: of those episodes.
        ranked: identifiers of the methods that compete.
    """
    pairs = [*TWINS.items(), *((metric, "psnr") for metric in TWINS)]
    return [found for pair in pairs if (found := _agreement(episodes, coverages, ranked, *pair)) is not None]


def agreement_listing(found: Sequence[CoverageAgreement]) -> Listing:
    """Return one record for each scene, for all of them, and for the order of methods."""
    records: list[tuple[str | int, ...]] = []
    for each in found:
        rows = [("spearman", scene, count, value) for scene, (value, count) in each.scenes.items()]
        rows.append(("spearman", "mean over scenes", len(each.scenes), each.within_scenes))
        rows.append(("spearman", "all together", each.pooled[1], each.pooled[0]))
        rows.append(("kendall", "means of methods", each.compared, each.methods))
        records += [
            (each.metric, each.other, statistic, scene, count, plain(value.value, _DECIMALS), value.reason or "")
            for statistic, scene, count, value in rows
        ]
    return Listing(FIELDS, tuple(records))


def _agreement(
    episodes: Episodes, coverages: Coverages, ranked: Sequence[str], metric: str, other: str
) -> CoverageAgreement | None:
    """Return how two metrics agree, or None if an episode lacks one of them."""
    found: dict[str, dict[frozenset[str], list[_Pair]]] = {}
    of_methods: dict[str, list[_Pair]] = {}
    for episode in episodes.all:
        pair = _pair(episodes, coverages, episode, metric, other)
        if pair is None:
            return None
        same_views = found.setdefault(episode.scene, {}).setdefault(frozenset(views_of(episode)), [])
        same_views.append(pair)
        of_methods.setdefault(episode.method, []).append(pair)
    scenes = {scene: np.array([np.mean(pairs, axis=0) for pairs in found[scene].values()]) for scene in sorted(found)}
    compared = [method for method in ranked if episodes.complete_seeds(method)]
    means = np.array([np.mean(of_methods[method], axis=0) for method in compared]).reshape(-1, 2)
    together = np.concatenate(list(scenes.values())) if scenes else np.zeros((0, 2))
    return CoverageAgreement(
        metric,
        other,
        {scene: (spearman(*table.T), len(table)) for scene, table in scenes.items()},
        (spearman(*together.T), len(together)),
        kendall(*means.T),
        len(compared),
    )


def _pair(episodes: Episodes, coverages: Coverages, episode: Episode, metric: str, other: str) -> _Pair | None:
    cell = (episode.scene, episode.seed)
    first = coverage_value(coverages, episode.method, cell, metric)
    if other == "psnr":
        second = scene_value(episodes, episode.method, *cell, other)
    else:
        second = coverage_value(coverages, episode.method, cell, other)
    return None if first is None or second is None else (first, second)
