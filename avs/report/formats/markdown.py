"""Tables as Markdown: the best value bold, the second and third numbered."""

from __future__ import annotations

from collections.abc import Sequence

from avs.report.formats import wording
from avs.report.tables.summary import Row, Table
from metrics.definitions import Metric

_DASH = "–"  # noqa: RUF001 (the dash of an empty cell)
_MARKS = {1: "**{}**", 2: "{} (2)", 3: "{} (3)"}


def table_markdown(table: Table) -> str:
    """Return the caption, the table, the comparison with the reference method, and the notes."""
    blocks = [" ".join(wording.caption(table)) + " Best in bold, second and third numbered.", grid(table)]
    title = wording.comparison_title(table)
    if title is not None:
        blocks += [title + ":", _comparison(table)]
    return document(blocks, wording.notes(table))


def document(blocks: Sequence[str], lines: Sequence[str]) -> str:
    """Return blocks of text with the notes ``lines`` below them."""
    listed = ["Notes:\n\n" + "\n".join(f"- {line}" for line in lines)] if lines else []
    return "\n\n".join([*blocks, *listed]) + "\n"


def grid(table: Table) -> str:
    """Return the rows by group, with the best three values of each metric marked."""
    header, align = ["", "Method"], ["---", "---"]
    for metric in table.metrics:
        columns = [_title(metric), *(["published", "difference"] if table.has_published else [])]
        header += columns
        align += ["---:"] * len(columns)
    ranked = {metric.identifier: wording.ranks(table, metric) for metric in table.metrics}
    lines = [header, align]
    for group, rows in wording.grouped(table):
        for index, row in enumerate(rows):
            cells = [group if index == 0 else "", row.label]
            for metric in table.metrics:
                cells += _cells(table, row, metric, ranked[metric.identifier].get(row.method))
            lines.append(cells)
    return pipe(lines)


def _cells(table: Table, row: Row, metric: Metric, rank: int | None) -> list[str]:
    entry = row.entries[metric.identifier]
    value = wording.measured(entry, metric, " ± ") or wording.missing_cause(table, row, metric) or _DASH
    cells = [minus(_MARKS[rank].format(value) if rank else value)]
    if table.has_published:
        cells.append(entry.published or _DASH)
        cells.append(_DASH if entry.difference is None else minus(wording.signed(entry.difference, metric)))
    return cells


def _comparison(table: Table) -> str:
    lines = [["Method", *map(_title, table.metrics)], ["---", *["---:"] * len(table.metrics)]]
    for _, rows in wording.grouped(table):
        for row in rows:
            if row is not table.reference:
                texts = [wording.against(row.entries[metric.identifier], metric) for metric in table.metrics]
                lines.append([row.label, *(_DASH if text is None else minus(text) for text in texts)])
    return pipe(lines)


def _title(metric: Metric) -> str:
    arrow = {True: " ↑", False: " ↓", None: ""}[metric.higher_is_better]
    return f"{metric.name}{arrow}" + (f" ({metric.unit})" if metric.unit else "")


def minus(text: str) -> str:
    """Return ``text`` with typographic minus signs."""
    return text.replace("-", "−")  # noqa: RUF001 (the typographic minus)


def pipe(lines: Sequence[Sequence[str]]) -> str:
    """Return a table from its header, its alignments and its rows."""
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)
