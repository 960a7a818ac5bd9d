"""Tables as Markdown: the best value bold, the second and third numbered."""

from __future__ import annotations

import re
from collections.abc import Sequence

from avs.report.document import Cell, Column, Comparison, Document, Group
from avs.report.formats.numbers import compared, measured, signed
from avs.report.formats.plain_text import one_line
from metrics.definitions import Metric

_DASH = "–"  # noqa: RUF001 (the dash of an empty cell)
_MARKS = {1: "**{}**", 2: "{} (2)", 3: "{} (3)"}
_LEGEND = "Best in bold, second and third numbered."

# What would change the look or the meaning of running text. An underscore within a word does not, so that names of
# scenes stay as they are.
_ACTIVE = re.compile(r"[\\`*|$<>~\[\]]|&(?=#?\w+;)|(?<![A-Za-z0-9])_|_(?![A-Za-z0-9])")
_FIRST = re.compile(r"^(?=[#+=-])|^(\d+)(?=[.)])")  # begins a heading, a list or an underline


def document_markdown(document: Document) -> str:
    """Return the caption, the table, the comparison with the reference method, and the notes."""
    blocks = [" ".join([*map(escaped, document.caption), _LEGEND]), _grid(document)]
    if document.comparison is not None:
        blocks += [escaped(document.comparison.title) + ":", _comparison(document.comparison, document.columns)]
    if document.notes:
        blocks.append("Notes:\n\n" + "\n".join(f"- {escaped(note)}" for note in document.notes))
    return "\n\n".join(blocks) + "\n"


def escaped(text: str) -> str:
    """Return ``text`` on one line, with a backslash before each character that Markdown would take as a command."""
    line = _ACTIVE.sub(r"\\\g<0>", one_line(text))
    return _FIRST.sub(lambda found: f"{found[1]}\\" if found[1] else "\\", line)


def _grid(document: Document) -> str:
    """Return the rows by group, with the best three values of each column marked."""
    header, align = ["", escaped(document.rows_are)], ["---", "---"]
    for column in document.columns:
        titles = [_over(column) + _title(column.metric), *_beside(column)]
        header += titles
        align += ["---:"] * len(titles)
    lines = [header, align]
    for group in document.groups:
        for index, row in enumerate(group.rows):
            texts = [_heading(group) if index == 0 else "", escaped(row.label)]
            for column, cell in zip(document.columns, row.cells, strict=True):
                texts += _texts(column, cell, (group.metric or column.metric).decimals)
            lines.append(texts)
    return _pipe(lines)


def _texts(column: Column, cell: Cell, decimals: int) -> list[str]:
    value = measured(cell, decimals, " ± ")
    if value is None:
        texts = [escaped(cell.cause) if cell.cause else _DASH]
    else:
        texts = [_minus(_MARKS[cell.rank].format(value) if cell.rank else value)]
    if column.published:
        texts.append(cell.published or _DASH)
    if column.difference:
        texts.append(_DASH if cell.difference is None else _minus(signed(cell.difference, decimals)))
    return texts


def _comparison(comparison: Comparison, columns: Sequence[Column]) -> str:
    metrics = [column.metric for column in columns]
    lines = [["Method", *map(_title, metrics)], ["---", *["---:"] * len(metrics)]]
    for label, differences in comparison.rows:
        pairs = zip(metrics, differences, strict=True)
        lines.append(
            [escaped(label), *(_DASH if each is None else _minus(compared(each, m.decimals)) for m, each in pairs)]
        )
    return _pipe(lines)


def _beside(column: Column) -> list[str]:
    """Return the headings of what stands beside a column."""
    headings = [escaped(column.published)] if column.published else []
    return [*headings, "difference"] if column.difference else headings


def _over(column: Column) -> str:
    return "" if column.over is None else f"{escaped(column.over)}: "


def _heading(group: Group) -> str:
    """Return the heading of a group, with the metric that all of its numbers are."""
    return " ".join([*([escaped(group.name)] if group.name else []), *([_title(group.metric)] if group.metric else [])])


def _title(metric: Metric) -> str:
    arrow = {True: " ↑", False: " ↓", None: ""}[metric.higher_is_better]
    return f"{escaped(metric.name)}{arrow}" + (f" ({escaped(metric.unit)})" if metric.unit else "")


def _minus(text: str) -> str:
    """Return ``text`` with typographic minus signs."""
    return text.replace("-", "−")  # noqa: RUF001 (the typographic minus)


def _pipe(lines: Sequence[Sequence[str]]) -> str:
    """Return a table from its header, its alignments and its rows, whose texts are escaped."""
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
