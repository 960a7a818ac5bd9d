r"""Tables as LaTeX in the form of the paper's Table 1, to be read by ``\input``."""

from __future__ import annotations

from collections.abc import Sequence

from avs.report.formats import wording
from avs.report.tables.summary import Row, Table
from metrics.definitions import Metric

# The paper's shades of the best, second and third value.
_COLOURS = {1: "F4CCCC", 2: "FCE5CD", 3: "D9EAD3"}
_DASH = "--"
# A rule sets the paper's own methods off from the others of their group, as in the paper.
_OWN = "ours-"
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
    "±": r"$\pm$",
}


def table_latex(table: Table) -> str:
    """Return a ``table*`` environment: caption, label, the table, the comparison, and the notes.

    It needs the packages booktabs, multirow, and xcolor with the option ``table``.
    """
    body = grid(table)
    title = wording.comparison_title(table)
    if title is not None:
        body += ["", r"\medskip", rf"{escape(title)}:", "", r"\smallskip", *_comparison(table)]
    return environment("nvs", table.episodes.dataset, wording.caption(table), body, wording.notes(table))


def environment(kind: str, dataset: str, sentences: Sequence[str], body: Sequence[str], remarks: Sequence[str]) -> str:
    """Return a ``table*`` environment.

    Args:
        kind: the first part of the label, ``tab:<kind>-<data set>``.
        dataset: name of the data set.
        sentences: of the caption, before the legend of the shades.
        body: lines of LaTeX.
        remarks: notes below it.
    """
    lines = [
        r"% needs \usepackage{booktabs,multirow} and \usepackage[table]{xcolor}",
        r"\begin{table*}[t]",
        r"\centering",
        r"\small",
        r"\setlength{\tabcolsep}{4pt}",
        rf"\caption{{{escape(' '.join(sentences))} {_legend()}}}",
        rf"\label{{tab:{kind}-{dataset.replace('_', '-')}}}",
        *body,
    ]
    for remark in remarks:
        lines += ["", r"\smallskip", rf"\parbox{{\linewidth}}{{\footnotesize {escape(remark)}.}}"]
    return "\n".join([*lines, r"\end{table*}"]) + "\n"


def escape(text: str) -> str:
    """Return ``text`` with the characters escaped that LaTeX takes as commands."""
    return "".join(_SPECIAL.get(character, character) for character in text)


def _legend() -> str:
    words = ("best", "second", "third")
    boxes = (rf"\colorbox[HTML]{{{_COLOURS[rank]}}}{{\strut {word}}}" for rank, word in enumerate(words, start=1))
    return "".join(boxes) + "."


def grid(table: Table) -> list[str]:
    """Return the rows by group as a ``tabular``, with the best three values of each metric shaded."""
    width = 3 if table.has_published else 1
    columns = len(table.metrics) * width
    lines = [rf"\begin{{tabular}}{{ll{'r' * columns}}}", r"\toprule"]
    if table.has_published:
        spans = (rf"\multicolumn{{3}}{{c}}{{{_title(metric)}}}" for metric in table.metrics)
        rules = (rf"\cmidrule(lr){{{start}-{start + 2}}}" for start in range(3, 3 + columns, 3))
        lines += [f" & & {' & '.join(spans)} \\\\", " ".join(rules)]
        lines.append(" & Method" + " & here & paper & diff." * len(table.metrics) + r" \\")
    else:
        lines.append(f" & Method & {' & '.join(map(_title, table.metrics))} \\\\")
    ranked = {metric.identifier: wording.ranks(table, metric) for metric in table.metrics}
    for group, rows in wording.grouped(table):
        lines.append(r"\midrule")
        for index, row in enumerate(rows):
            cells = [rf"\multirow{{{len(rows)}}}{{*}}{{{escape(group)}}}" if index == 0 else "", escape(row.label)]
            for metric in table.metrics:
                cells += _cells(table, row, metric, ranked[metric.identifier].get(row.method))
            if index > 0 and row.method.startswith(_OWN) and not rows[index - 1].method.startswith(_OWN):
                lines.append(rf"\cmidrule(l){{2-{2 + columns}}}")
            lines.append(" & ".join(cells) + r" \\")
    return [*lines, r"\bottomrule", r"\end{tabular}"]


def _cells(table: Table, row: Row, metric: Metric, rank: int | None) -> list[str]:
    entry = row.entries[metric.identifier]
    value = wording.measured(entry, metric, r" $\pm$ ") or _cause(table, row, metric) or _DASH
    if entry.mean is not None and value.startswith("-"):
        value = f"$-${value[1:]}"  # a hyphen otherwise
    cells = [rf"\cellcolor[HTML]{{{_COLOURS[rank]}}}{value}" if rank else value]
    if table.has_published:
        cells.append(entry.published or _DASH)
        cells.append(_DASH if entry.difference is None else f"${wording.signed(entry.difference, metric)}$")
    return cells


def _cause(table: Table, row: Row, metric: Metric) -> str | None:
    cause = wording.missing_cause(table, row, metric)
    return None if cause is None else rf"{{\scriptsize {escape(cause)}}}"


def _comparison(table: Table) -> list[str]:
    lines = [rf"\begin{{tabular}}{{l{'r' * len(table.metrics)}}}", r"\toprule"]
    lines += [f"Method & {' & '.join(map(_title, table.metrics))} \\\\", r"\midrule"]
    for _, rows in wording.grouped(table):
        for row in rows:
            if row is not table.reference:
                texts = [wording.against(row.entries[metric.identifier], metric) for metric in table.metrics]
                cells = [_DASH if text is None else rf"${text}$" for text in texts]
                lines.append(" & ".join([escape(row.label), *cells]) + r" \\")
    return [*lines, r"\bottomrule", r"\end{tabular}"]


def _title(metric: Metric) -> str:
    arrow = {True: r" $\uparrow$", False: r" $\downarrow$", None: ""}[metric.higher_is_better]
    return f"{metric.name}{arrow}" + (f" ({metric.unit})" if metric.unit else "")
