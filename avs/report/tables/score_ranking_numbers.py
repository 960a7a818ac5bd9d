"""The numbers of the ranking table: do a method's scores order the candidates as the truth does?"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import get_args

import numpy as np
import numpy.typing as npt

from avs.nvs.common_states_record import CommonState
from avs.report.collect import Cell
from avs.report.collect_states import StateRecords
from avs.selection import registry
from avs.selection.contract import Direction, TruthName
from avs.system.reasons import Reason
from metrics.definitions import Metric
from metrics.ranking import Correlation, kendall, spearman
from metrics.statistics import Interval, interval_over_scenes, spread_of

FloatArray = npt.NDArray[np.float64]
Values = Sequence[float | None]

STATISTICS = {"spearman": spearman, "kendall": kendall}
"""Rank correlations by identifier."""

_NAMES: dict[TruthName, str] = {"ssim": "SSIM", "psnr": "PSNR", "gain": "gain"}


@dataclass(frozen=True)
class Correlated:
    """One correlation: which truth, which statistic, and how the column is printed."""

    target: TruthName
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
    for target in get_args(TruthName)
    for statistic in STATISTICS
)
"""The columns, in order."""


@dataclass(frozen=True)
class StateCorrelation:
    """One correlation at one state.

    Attributes:
        cell: scene and seed.
        views: number of captured views.
        candidates: how many have a score and the truth.
        correlation: the value, or why there is none.
    """

    cell: Cell
    views: int
    candidates: int
    correlation: Correlation


@dataclass(frozen=True)
class Ranking:
    """One correlation of one method.

    Attributes:
        mean: mean over scenes and seeds of the mean over states, or None with a reason in ``missing``.
        spread: standard deviation (n - 1) over all states; None for fewer than three.
        interval: 95 % interval of the mean over scenes of this kind; None for one scene.
        states: the correlation at each state, those that are undefined too.
        missing: why there is no mean, or None.
    """

    mean: float | None = None
    spread: float | None = None
    interval: Interval | None = None
    states: Sequence[StateCorrelation] = field(default_factory=list)
    missing: Reason | None = None

    @property
    def defined(self) -> list[StateCorrelation]:
        """The states in the mean."""
        return [each for each in self.states if each.correlation.value is not None]

    @property
    def left_out(self) -> dict[str, int]:
        """The states whose correlation is undefined, by reason."""
        reasons = (each.correlation.reason for each in self.states)
        return dict(sorted(Counter(reason for reason in reasons if reason is not None).items()))


def summarise_ranking(
    records: StateRecords, methods: Sequence[str], absent: Mapping[str, Reason]
) -> dict[str, dict[str, Ranking]]:
    """Compute every correlation, by identifier of the method and of the column.

    Args:
        records: the common states of one data set.
        methods: identifiers of the rows; those without numbers have the reason.
        absent: why a method has no scores, by identifier.
    """
    return {
        method: {column.metric.identifier: _ranking(records, method, column, absent) for column in COLUMNS}
        for method in methods
    }


def oriented(scores: Values, chooses: Direction, truth: Values, target: TruthName) -> tuple[FloatArray, FloatArray]:
    """Return the scores and the truth of the candidates that have both, each turned so that the first choice is high.

    A method takes the lowest or the highest score first, as ``chooses`` tells. The truth has the lowest SSIM or PSNR
    first, as the paper's hypothesis says, and the highest gain. Two arrays ``[n]``.
    """
    both = [pair for pair in zip(scores, truth, strict=True) if None not in pair]
    values = np.array(both, dtype=np.float64).reshape(-1, 2)
    return values[:, 0] * (1 if chooses == "highest" else -1), values[:, 1] * (1 if target == "gain" else -1)


def truth_of(state: CommonState, target: TruthName) -> Values | None:
    """Return a truth of the candidates of a state, of the gain the mean of its measurements; None if not measured."""
    if target != "gain":
        values: Values = getattr(state, target)
        return values
    if state.gains is None:
        return None
    return [None if None in pair else float(np.mean(pair)) for pair in zip(*state.gains, strict=True)]


def averaged(states: Sequence[StateCorrelation]) -> Ranking:
    """Return the mean over scenes of that over seeds of that over states, where each has a correlation at least."""
    cells: dict[Cell, list[float]] = {each.cell: [] for each in states}
    for each in states:
        if each.correlation.value is not None:
            cells[each.cell].append(each.correlation.value)
    empty = [cell for cell, values in cells.items() if not values]
    if empty:
        return Ranking(states=states, missing=Reason(cause=_undefined(states, empty, len(empty) == len(cells))))
    every = [value for values in cells.values() for value in values]
    scenes: dict[str, list[float]] = {}
    for (scene, _), values in cells.items():
        scenes.setdefault(scene, []).append(float(np.mean(values)))
    interval = interval_over_scenes(list(scenes.values()))
    return Ranking(float(np.mean([np.mean(values) for values in scenes.values()])), spread_of(every), interval, states)


def _undefined(states: Sequence[StateCorrelation], empty: Sequence[Cell], everywhere: bool) -> str:
    """Say why the correlation is undefined at all states of the cells ``empty``: once for those of equal reasons."""
    places: dict[str, list[str]] = {}
    for scene, seed in empty:
        reasons = {each.correlation.reason for each in states if each.cell == (scene, seed)}
        places.setdefault(", ".join(sorted(filter(None, reasons))), []).append(f"{scene} with seed {seed}")
    if everywhere and len(places) == 1:
        return next(iter(places))
    return "; ".join(f"{', '.join(cells)}: {reason}" for reason, cells in places.items())


def measured_by(method: str) -> TruthName | None:
    """Return the truth that stands in the row of an oracle, or None of a method that has a score of its own."""
    registered = registry.methods().get(method)
    return None if registered is None else registered.method.measures


def _ranking(records: StateRecords, method: str, column: Correlated, absent: Mapping[str, Reason]) -> Ranking:
    if method in absent:
        return Ranking(missing=absent[method])
    if any(truth_of(state, column.target) is None for _, state in records.states):
        return Ranking(missing=Reason(cause="not measured: the reconstruction cannot be copied"))
    measures = measured_by(method)
    if measures is not None:
        if measures == column.target:
            return Ranking(missing=Reason(cause="is this truth itself"))
        return averaged(_of_truth(records, measures, registry.find(method).method.chooses, column))
    scored = records.of_method(method)
    reason = _unscored(records, method)
    if reason is not None:
        return Ranking(missing=reason)
    found = []
    for cell, record in records.cells.items():
        for state, scores in zip(record.states, scored[cell].scores, strict=True):
            assert scores is not None  # _unscored has looked
            found.append(_correlated(cell, state, scores, scored[cell].chooses, column))
    return averaged(found)


def _of_truth(
    records: StateRecords, measures: TruthName, chooses: Direction, column: Correlated
) -> list[StateCorrelation]:
    """Return the correlations of one truth, which an oracle has as its score, with another."""
    measured = ((cell, state, truth_of(state, measures)) for cell, state in records.states)
    return [
        _correlated(cell, state, [None] * len(state.candidates) if scores is None else scores, chooses, column)
        for cell, state, scores in measured
    ]


def _correlated(
    cell: Cell, state: CommonState, scores: Values, chooses: Direction, column: Correlated
) -> StateCorrelation:
    truth = truth_of(state, column.target)
    assert truth is not None  # _ranking has looked
    pair = oriented(scores, chooses, truth, column.target)
    return StateCorrelation(cell, state.views, len(pair[0]), STATISTICS[column.statistic](*pair))


def _unscored(records: StateRecords, method: str) -> Reason | None:
    """Say why a method lacks the scores of a state, or return None if it has all."""
    scored = records.of_method(method)
    if not scored:
        return Reason(cause="not scored")
    failures: dict[str, list[str]] = {}
    for (scene, seed), each in scored.items():
        if each.failure is not None:
            failures.setdefault(each.failure, []).append(f"{scene} with seed {seed}")
    if failures:
        told = "; ".join(f"{', '.join(places)}: {failure}" for failure, places in failures.items())
        alike = len(failures) == 1 and all(each.failure is not None for each in scored.values())
        remedy = next(iter(failures)) if alike else told
        return Reason(cause="it failed", remedy=remedy)
    if any(scores is None for each in scored.values() for scores in each.scores):
        return Reason(cause="the method records no scores")
    return None
