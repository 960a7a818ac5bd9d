"""What all tables do the same way: rows in groups, and the best three values of each column marked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from avs.report.document import Cell, Column, Group, Row
from avs.report.labels import GROUPS
from avs.report.methods import Presented
from avs.selection.contract import UNRANKED
from metrics.definitions import Metric

_MARKED = 3


def in_groups(methods: Sequence[Presented]) -> list[tuple[str, list[Presented]]]:
    """Return the methods by group: known groups in their order, others as they first occur, then those unranked."""
    others = (method.group for method in methods if method.competes)
    names = dict.fromkeys([*GROUPS, *others, *UNRANKED])
    groups = [(name, [method for method in methods if method.group == name]) for name in names]
    return [(name, members) for name, members in groups if members]


def arranged(
    columns: Sequence[Column], methods: Sequence[Presented], cells: Mapping[str, Sequence[Cell]]
) -> tuple[Group, ...]:
    """Return the rows in groups, with ranks.

    Args:
        columns: the columns of the table.
        methods: its rows, in order.
        cells: one for each column, by identifier of the method; their ranks are set here.
    """
    ranked = {method.identifier: list(cells[method.identifier]) for method in methods}
    for index, column in enumerate(columns):
        own = {method.identifier: cells[method.identifier][index] for method in methods if method.ranked}
        values = {identifier: cell.value for identifier, cell in own.items() if cell.ranked}
        for identifier, rank in ranks(values, column.metric).items():
            ranked[identifier][index] = replace(ranked[identifier][index], rank=rank)
    return tuple(
        Group(name, tuple(_row(each, ranked[each.identifier]) for each in members))
        for name, members in in_groups(methods)
    )


def _row(method: Presented, cells: Sequence[Cell]) -> Row:
    return Row(method.label, tuple(cells), method.proposed, method.identifier, method.ranked)


def ranks(values: Mapping[str, float | None], metric: Metric) -> dict[str, int]:
    """Return 1, 2 or 3 for the best three printed values.

    Values that print the same share a rank, and the next value has the next rank, as in the paper's Table 1. A quantity
    without a direction has no ranks.
    """
    if metric.higher_is_better is None:
        return {}
    printed = {name: float(f"{value:.{metric.decimals}f}") for name, value in values.items() if value is not None}
    best = sorted(set(printed.values()), reverse=metric.higher_is_better)[:_MARKED]
    return {name: best.index(value) + 1 for name, value in printed.items() if value in best}
