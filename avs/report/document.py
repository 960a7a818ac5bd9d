"""A table before it takes a form: all that its Markdown, LaTeX and csv hold, whatever it was computed from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from metrics.definitions import Metric


@dataclass(frozen=True)
class Column:
    """One quantity.

    Attributes:
        metric: its name, direction, decimals and unit.
        published: heading of the paper's values, which then stand beside each cell, or None.
        difference: whether the difference to the paper's value stands there, too.
        over: heading above it and its neighbours that have the same, such as a data set; or None.
    """

    metric: Metric
    published: str | None = None
    difference: bool = False
    over: str | None = None


@dataclass(frozen=True)
class Cell:
    """One quantity of one row.

    Attributes:
        value: the number, or None if it is missing.
        spread: what stands after the plus-minus sign, or None.
        rank: 1, 2 or 3 for the best three values of the column, or None.
        published: the paper's value with its digits, or None.
        cause: words that stand in place of a missing number, or None for a dash.
        text: a number that is printed with the digits it has here, in place of the value; or None.
        ranked: whether the value may have a rank where its row competes.
    """

    value: float | None = None
    spread: float | None = None
    rank: int | None = None
    published: str | None = None
    cause: str | None = None
    text: str | None = None
    ranked: bool = True

    @property
    def difference(self) -> float | None:
        """The value minus the published one, or None where one of them is missing."""
        return None if self.value is None or self.published is None else self.value - float(self.published)


@dataclass(frozen=True)
class Row:
    """One method, or what else a table has in its rows.

    Attributes:
        label: its printed name.
        cells: one for each column.
        proposed: whether the paper proposes it; a rule may set such rows off from the others.
        identifier: of the method, by which a page finds its episodes; empty for what else a table has in its rows.
        ranked: whether it competes for ranks.
    """

    label: str
    cells: tuple[Cell, ...]
    proposed: bool = False
    identifier: str = ""
    ranked: bool = False


@dataclass(frozen=True)
class Group:
    """Rows under one heading.

    Attributes:
        name: the heading.
        rows: its rows.
        metric: what all numbers of its rows are, where columns are not metrics; it is part of the heading then.
    """

    name: str
    rows: tuple[Row, ...]
    metric: Metric | None = None


@dataclass(frozen=True)
class Difference:
    """The difference of a row to the reference method in one column.

    Attributes:
        value: the mean of the paired differences.
        interval: lower and upper end of its confidence interval, or None if there is none.
    """

    value: float
    interval: tuple[float, float] | None


@dataclass(frozen=True)
class Comparison:
    """A second section: each row's difference to one method.

    Attributes:
        title: with what the rows are compared, and what the intervals are.
        rows: label and differences by column, in the order of the first section; None where there is none.
    """

    title: str
    rows: tuple[tuple[str, tuple[Difference | None, ...]], ...]


@dataclass(frozen=True)
class Listing:
    """Numbers for other programs.

    Attributes:
        fields: their names.
        records: as many values each; empty text is missing.
        exact: the last value of each record with all its digits, where a page computes with it; else empty.
    """

    fields: tuple[str, ...]
    records: tuple[tuple[str | int, ...], ...]
    exact: tuple[float | None, ...] = ()


@dataclass(frozen=True)
class Document:
    """A table.

    Attributes:
        label: identifier, such as ``nvs-orbit``, by which LaTeX refers to it.
        caption: sentences.
        columns: its columns.
        groups: its rows.
        notes: what a reader must know beside the numbers, without full stops.
        listing: the same numbers with more digits, for a csv file.
        comparison: the second section, or None.
        appendices: further csv files, by what is appended to the name of the table, such as ``_per_scene``.
        rows_are: heading of the labels of rows.
    """

    label: str
    caption: tuple[str, ...]
    columns: tuple[Column, ...]
    groups: tuple[Group, ...]
    notes: tuple[str, ...]
    listing: Listing
    comparison: Comparison | None = None
    appendices: Mapping[str, Listing] = field(default_factory=dict)
    rows_are: str = "Method"
