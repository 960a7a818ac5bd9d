"""How far the measured gain can be trusted: two measurements with independent random streams, compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avs.report.collect_states import StateRecords
from avs.report.document import Listing
from avs.report.formats.numbers import plain
from avs.report.tables.score_ranking_numbers import STATISTICS, Ranking, StateCorrelation, averaged
from metrics.reliability import correlation_bound, spearman_brown

FIELDS = ("scene", "seed", "views", "candidates", "spearman", "kendall", "spread_db", "noise_db")
"""Columns of the csv file: of each state the correlation of the measurements, and the gains' spread and noise."""

_DECIMALS = 4


@dataclass(frozen=True)
class Reliability:
    """What two measurements of the gain say of each other.

    Attributes:
        retest: the correlation of the two, by identifier of the statistic.
        of_mean: of the mean of both with another such mean, by Spearman and Brown; None without a correlation.
        bound: largest correlation of a score with that mean that is to be expected; None without a correlation.
    """

    retest: dict[str, Ranking]
    of_mean: float | None
    bound: float | None


def reliability(records: StateRecords) -> Reliability | None:
    """Return the reliability of the gain over all states, or None where it is not measured."""
    if any(state.gains is None for _, state in records.states):
        return None
    retest = {statistic: averaged(_retested(records, statistic)) for statistic in STATISTICS}
    mean = retest["spearman"].mean
    of_mean = None if mean is None else spearman_brown(mean)
    return Reliability(retest, of_mean, None if of_mean is None else correlation_bound(of_mean))


def reliability_listing(records: StateRecords) -> Listing:
    """Return one record for each state."""
    found: list[tuple[str | int, ...]] = []
    retest = {statistic: _retested(records, statistic) for statistic in STATISTICS}
    for row, ((scene, seed), state) in enumerate(records.states):
        pairs = _pairs(state.gains)
        values = (plain(retest[statistic][row].correlation.value, _DECIMALS) for statistic in STATISTICS)
        decibels = (_deviation(pairs.mean(axis=1)), _deviation(pairs[:, 0] - pairs[:, 1]))
        noise = None if decibels[1] is None else decibels[1] / np.sqrt(2)
        found.append(
            (scene, seed, state.views, len(pairs), *values, plain(decibels[0], _DECIMALS), plain(noise, _DECIMALS))
        )
    return Listing(FIELDS, tuple(found))


def _retested(records: StateRecords, statistic: str) -> list[StateCorrelation]:
    return [
        StateCorrelation(cell, state.views, len(pairs), STATISTICS[statistic](pairs[:, 0], pairs[:, 1]))
        for cell, state in records.states
        for pairs in [_pairs(state.gains)]
    ]


def _pairs(gains: list[list[float | None]] | None) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return both measurements of the candidates that have them, ``[n, 2]``."""
    pairs = [] if gains is None else [pair for pair in zip(*gains, strict=True) if None not in pair]
    return np.array(pairs, dtype=np.float64).reshape(-1, 2)


def _deviation(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float | None:
    return float(values.std(ddof=1)) if len(values) > 1 else None
