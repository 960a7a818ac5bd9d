"""The numbers of the coverage table: what is taken of each episode's record."""

from __future__ import annotations

from collections.abc import Callable

from avs.coverage.coverage_record import Coverage
from avs.report.collect import Cell, Episodes
from avs.report.collect_coverage import Coverages
from avs.report.tables.view_synthesis_numbers import Quantities
from avs.system.reasons import Reason
from metrics.definitions import COVERAGE, Metric

_Value = Callable[[Coverage], float | None]

_VALUES: dict[str, _Value] = {
    "scr_percent": lambda record: None if (found := record.against_reference) is None else 100.0 * found.scr,
    "f_score": lambda record: None if (found := record.against_reference) is None else found.f_score,
    "toolbox_f_score": lambda record: None if (found := record.against_reference) is None else found.toolbox_f_score,
    "true_scr_percent": lambda record: None if (found := record.against_surface) is None else 100.0 * found.scr,
    "true_f_score": lambda record: None if (found := record.against_surface) is None else found.f_score,
    "cloud_points": lambda record: float(record.points),
    "registered_views": lambda record: float(len(record.registered)),
}
"""The number of a record, by identifier of the metric."""

TRUE = ("true_scr_percent", "true_f_score")
"""Metrics against the true surface."""


def columns_of(coverages: Coverages) -> tuple[Metric, ...]:
    """Return the columns; without any record against a true surface, those of it are left out."""
    known = any(record.against_surface is not None for record in coverages.all)
    return tuple(metric for metric in COVERAGE.values() if known or metric.identifier not in TRUE)


def coverage_value(coverages: Coverages, method: str, cell: Cell, metric: str) -> float | None:
    """Return the number of an episode, or None if it has none."""
    record = coverages.record(method, cell)
    return None if record is None else _VALUES[metric](record)


def quantities_of(coverages: Coverages) -> Quantities:
    """Return what the coverage table has of each episode."""

    def value(episodes: Episodes, method: str, scene: str, seed: int, metric: str) -> float | None:
        return coverage_value(coverages, method, (scene, seed), metric)

    def why_not(episodes: Episodes, method: str, scene: str, seed: int, metric: str) -> Reason:
        record = coverages.record(method, (scene, seed))
        if record is None:
            return coverages.lacking or Reason(cause="coverage not measured")
        group = "against_surface" if metric in TRUE else "against_reference"
        return Reason(cause="not measured", remedy=record.absent.get(group))

    return Quantities(columns_of(coverages), value, why_not)
