r"""Tables as LaTeX in the form of the paper's Table 1, to be read by ``\input``."""

from __future__ import annotations

import itertools
import unicodedata
from collections.abc import Sequence
from dataclasses import replace

from avs.report.document import Cell, Column, Comparison, Document, Group
from avs.report.formats.numbers import compared, measured, signed
from avs.report.formats.plain_text import one_line
from metrics.definitions import Metric

# The paper's shades of the best, second and third value.
_COLOURS = {1: "F4CCCC", 2: "FCE5CD", 3: "D9EAD3"}
_DASH = "--"
_SPECIAL = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "[": "{[}",  # behind the end of a row it would begin an option
    "]": "{]}",
    '"': "''",
    "`": r"\`{}",
    "±": r"$\pm$",
    "–": "--",  # noqa: RUF001
    "−": "$-$",  # noqa: RUF001
}

_MOST_COLUMNS = 16  # of numbers beside one another; more of them could not be read
_COLUMNS_OF_A_PART = 12
_LINES_OF_A_PAGE = 42  # of rows of table and comparison, in the size that tables have; more need smaller letters
_NOT_IN_OT1 = "«»ÐÞðþ"  # what LaTeX's first font encoding lacks of Latin-1


def document_latex(document: Document) -> str:
    """Return a ``table*`` environment with caption, label, the table and the comparison; and the notes behind it.

    It needs the packages booktabs, graphicx, multirow, and xcolor with the option ``table``, and no font encoding.
    Tables are scaled down to the width of the page where they are wider. Notes are no part of the floating table, so
    that they can go on over the end of a page.
    """
    lines = [
        r"% needs \usepackage{booktabs,graphicx,multirow} and \usepackage[table]{xcolor}",
        r"\begin{table*}[t]",
        r"\centering",
        r"\small" if _lines(document) <= _LINES_OF_A_PAGE else r"\footnotesize",
        r"\setlength{\tabcolsep}{4pt}",
        rf"\caption{{{_escape(' '.join(document.caption))} {_legend()}}}",
        rf"\label{{tab:{document.label.replace('_', '-')}}}",
        *_grid(document),
    ]
    if document.comparison is not None:
        lines += ["", r"\medskip", rf"{_escape(document.comparison.title)}:", "", r"\smallskip"]
        lines += _comparison(document.comparison, document.columns)
    return "\n".join([*lines, r"\end{table*}", *_notes(document)]) + "\n"


def _lines(document: Document) -> int:
    """Return the number of rows of all parts of the table and of the comparison."""
    compared = 0 if document.comparison is None else len(document.comparison.rows)
    return _parts(document) * sum(len(group.rows) for group in document.groups) + compared


def _notes(document: Document) -> list[str]:
    if not document.notes:
        return []
    notes = [rf"{_escape(note)}." for note in document.notes]
    reference = rf"Notes to Table~\ref{{tab:{document.label.replace('_', '-')}}}: "
    return [r"{\footnotesize\noindent", reference + notes[0], *notes[1:], r"\par}"]


def _escape(text: str) -> str:
    """Return ``text`` on one line, with the characters escaped that LaTeX takes as commands or does not know."""
    return "".join(_SPECIAL.get(character) or _printable(character) for character in one_line(text))


def _printable(character: str) -> str:
    """Return a character that every LaTeX prints in its first font: itself, its base letter, or its number."""
    if character.isascii() or ("¡" <= character <= "ÿ" and character not in _NOT_IN_OT1):
        return character
    base = "".join(part for part in unicodedata.normalize("NFKD", character) if not unicodedata.combining(part))
    return "".join(_SPECIAL.get(part, part) for part in base) if base.isascii() else f"{{[}}U+{ord(character):04X}{{]}}"


def _legend() -> str:
    words = ("best", "second", "third")
    boxes = (rf"\colorbox[HTML]{{{_COLOURS[rank]}}}{{\strut {word}}}" for rank, word in enumerate(words, start=1))
    return "".join(boxes) + "."


def _parts(document: Document) -> int:
    """Return how many tables below one another the columns need."""
    count = sum(map(_width, document.columns))
    return 1 if count <= _MOST_COLUMNS else -(-len(document.columns) // _COLUMNS_OF_A_PART)


def _grid(document: Document) -> list[str]:
    """Return the rows by group as a ``tabular``, or several below one another where there are too many columns."""
    size = -(-len(document.columns) // _parts(document))
    lines: list[str] = []
    for start in range(0, len(document.columns), size):
        lines += ["", r"\medskip", ""] if start else []
        lines += _part(document, slice(start, start + size))
    return lines


def _part(document: Document, shown: slice) -> list[str]:
    """Return some columns as a ``tabular``, with the best three values of each column shaded."""
    columns = document.columns[shown]
    width = sum(map(_width, columns))
    lines = [rf"\begin{{tabular}}{{ll{'r' * width}}}", r"\toprule"]
    lines += [*_spans(columns), *_header(columns, _escape(document.rows_are))]
    for group in document.groups:
        rows = tuple(replace(row, cells=row.cells[shown]) for row in group.rows)
        lines += [r"\midrule", *_rows(replace(group, rows=rows), columns, width)]
    return _within_page([*lines, r"\bottomrule", r"\end{tabular}"])


def _within_page(tabular: Sequence[str]) -> list[str]:
    """Return a ``tabular`` that is scaled down where it is wider than the page."""
    return [r"\resizebox{\ifdim\width>\textwidth\textwidth\else\width\fi}{!}{%", *tabular, "}"]


def _spans(columns: Sequence[Column]) -> list[str]:
    """Return the headings above neighbouring columns; none if no column has one."""
    if not any(column.over for column in columns):
        return []
    texts, rules, start = [], [], 3
    for over, members in itertools.groupby(columns, key=lambda column: column.over):
        width = sum(map(_width, members))
        texts.append(rf"\multicolumn{{{width}}}{{c}}{{{_escape(over or '')}}}")
        rules += [rf"\cmidrule(lr){{{start}-{start + width - 1}}}"] if over else []
        start += width
    return [f" & & {' & '.join(texts)} \\\\", " ".join(rules)]


def _width(column: Column) -> int:
    return 1 + (column.published is not None) + column.difference


def _header(columns: Sequence[Column], rows_are: str) -> list[str]:
    if not any(column.published for column in columns):
        return [f" & {rows_are} & {' & '.join(_title(column.metric) for column in columns)} \\\\"]
    spans, rules, names, start = [], [], [], 3
    for column in columns:
        title = _title(column.metric)
        width = _width(column)
        spans.append(rf"\multicolumn{{{width}}}{{c}}{{{title}}}" if width > 1 else title)
        names.append(f" & here & {_escape(column.published)}" if column.published else " & ")
        names.append(" & diff." if column.difference else "")
        if width > 1:
            rules.append(rf"\cmidrule(lr){{{start}-{start + width - 1}}}")
        start += width
    return [f" & & {' & '.join(spans)} \\\\", " ".join(rules), f" & {rows_are}{''.join(names)} \\\\"]


def _rows(group: Group, columns: Sequence[Column], width: int) -> list[str]:
    lines = []
    for index, row in enumerate(group.rows):
        # As in the paper, a rule sets its own methods off from the others of their group.
        if index > 0 and row.proposed and not group.rows[index - 1].proposed:
            lines.append(rf"\cmidrule(l){{2-{2 + width}}}")
        texts = [rf"\multirow{{{len(group.rows)}}}{{*}}{{{_heading(group)}}}" if index == 0 else ""]
        texts.append(_escape(row.label))
        for column, cell in zip(columns, row.cells, strict=True):
            texts += _texts(column, cell, (group.metric or column.metric).decimals)
        lines.append(" & ".join(texts) + r" \\")
    return lines


def _heading(group: Group) -> str:
    """Return the heading of a group, with the metric that all of its numbers are."""
    named = [_escape(group.name)] if group.name else []
    return " ".join([*named, *([_title(group.metric)] if group.metric else [])])


def _texts(column: Column, cell: Cell, decimals: int) -> list[str]:
    value = measured(cell, decimals, r" $\pm$ ")
    if value is None:
        value = _DASH if cell.cause is None else rf"{{\scriptsize {_escape(cell.cause)}}}"
    elif value.startswith("-"):
        value = f"$-${value[1:]}"  # a hyphen otherwise
    texts = [rf"\cellcolor[HTML]{{{_COLOURS[cell.rank]}}}{value}" if cell.rank else value]
    if column.published:
        texts.append(cell.published or _DASH)
    if column.difference:
        texts.append(_DASH if cell.difference is None else f"${signed(cell.difference, decimals)}$")
    return texts


def _comparison(comparison: Comparison, columns: Sequence[Column]) -> list[str]:
    metrics = [column.metric for column in columns]
    lines = [rf"\begin{{tabular}}{{l{'r' * len(metrics)}}}", r"\toprule"]
    lines += [f"Method & {' & '.join(map(_title, metrics))} \\\\", r"\midrule"]
    for label, differences in comparison.rows:
        pairs = zip(metrics, differences, strict=True)
        texts = [_DASH if each is None else f"${compared(each, metric.decimals)}$" for metric, each in pairs]
        lines.append(" & ".join([_escape(label), *texts]) + r" \\")
    return _within_page([*lines, r"\bottomrule", r"\end{tabular}"])


def _title(metric: Metric) -> str:
    arrow = {True: r" $\uparrow$", False: r" $\downarrow$", None: ""}[metric.higher_is_better]
    return f"{_escape(metric.name)}{arrow}" + (f" ({_escape(metric.unit)})" if metric.unit else "")
