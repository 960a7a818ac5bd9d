"""The paper's two tables of selection times in its layout: PSNR, time and memory; and time and PSNR of every method."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

from avs.nvs.timing_record import Runtime
from avs.report.collect import Episodes
from avs.report.document import Cell, Column, Document, Listing
from avs.report.formats.numbers import EXTRA_DECIMALS, plain
from avs.report.formats.writing import write_document
from avs.report.methods import Presented, presented_in_columns
from avs.report.published import Published, read_published
from avs.report.tables.arrangement import arranged
from avs.report.tables.selection_times import BESIDE, PUBLISHED_SCENE
from avs.report.tables.selection_times_numbers import COLUMNS, Times, read_runtimes, summarise_runtime
from avs.report.tables.table_notes import whole_row
from avs.report.tables.timing_words import (
    episodes_of_scene,
    is_ranked,
    ranked_times,
    timing_caption,
    timing_notes,
    untimed_methods,
)
from avs.system.reasons import Reason
from metrics.definitions import Metric

Summary = Literal["memory", "detail"]
"""Which of the two: PSNR, time and memory of the methods that the paper has there, or time and PSNR of all."""

SUMMARIES: dict[Summary, tuple[str, ...]] = {
    "memory": ("psnr", "selection_seconds", "peak_memory_gb"),
    "detail": ("selection_seconds", "psnr"),
}
"""The columns of each, in the order of the paper."""

FIELDS = ("method", "group", "metric", "value", "published", "note")
"""Columns of the csv file."""

_Numbers = Mapping[str, Mapping[str, Times]]


def write_runtime_summary(
    summary: Summary,
    records: Sequence[Path],
    episodes: Sequence[Path],
    methods: Sequence[str],
    absent: Mapping[str, Reason],
    published: Path,
    out: Path,
) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md`` and ``.tex``.

    Args:
        summary: which of the two tables.
        records: ``avs.nvs.timing_record.Runtime`` files, at most one for each method, all of one scene.
        episodes: ``episode.json`` files of that scene, for the PSNR.
        methods: see ``runtime_summary``.
        absent: see ``runtime_summary``.
        published: see ``runtime_summary``.
        out: path of the table without suffix.

    Raises:
        UserError: a record is missing, damaged, or not comparable with the others; or the published values cannot be
            read.
    """
    timed = read_runtimes(records)
    collected = episodes_of_scene(episodes, methods, timed)
    write_document(runtime_summary(summary, timed, collected, methods, absent, published), out)


def runtime_summary(
    summary: Summary,
    records: Mapping[str, Runtime],
    episodes: Episodes,
    methods: Sequence[str],
    absent: Mapping[str, Reason],
    published: Path,
    untimed: int = 0,
) -> Document:
    """Return one of the two tables.

    Args:
        summary: which.
        records: selection times by method, at least one.
        episodes: on the scene that they were measured on, for the PSNR.
        methods: identifiers of the methods, in the order of rows.
        absent: why a method is not timed, by identifier.
        published: the file of ``results/published`` with the values of the same table.
        untimed: number of methods whose times a run has asked for and does not have.

    Raises:
        UserError: the published values cannot be read.
    """
    paper = read_published(published, PUBLISHED_SCENE)
    rows = [presented_in_columns(method, [episodes]) for method in methods]
    metrics = [metric for name in SUMMARIES[summary] for metric in COLUMNS if metric.identifier == name]
    all_numbers = summarise_runtime(records, episodes, [row.identifier for row in rows], absent)
    numbers = {
        method: {metric.identifier: row[metric.identifier] for metric in metrics} for method, row in all_numbers.items()
    }
    timed = [records[row.identifier] for row in rows if row.identifier in records]
    columns = tuple(_column(metric, paper) for metric in ranked_times(metrics, timed))
    cells = {method: _cells(method, row, paper, episodes) for method, row in numbers.items()}
    return Document(
        label=f"runtime-{summary}",
        caption=(*untimed_methods(episodes, untimed), *timing_caption(timed or list(records.values()))),
        columns=columns,
        groups=arranged(columns, rows, cells),
        notes=tuple(timing_notes(rows, numbers, timed or list(records.values()), episodes, has_paper=True)),
        listing=_listing(rows, metrics, numbers, paper),
    )


def _column(metric: Metric, paper: Published) -> Column:
    known = any(name == BESIDE.get(metric.identifier) for _, name in paper.values)
    return Column(metric, "published, Garden" if known else None)


def _cells(method: str, row: Mapping[str, Times], paper: Published, episodes: Episodes) -> list[Cell]:
    whole = whole_row(times.missing for times in row.values())
    return [
        Cell(
            times.value,
            cause=whole.cause if whole is not None and index == 0 else None,
            published=paper.values.get((method, BESIDE.get(name, ""))),
            ranked=is_ranked(name, method, episodes),
        )
        for index, (name, times) in enumerate(row.items())
    ]


def _listing(rows: Sequence[Presented], metrics: Sequence[Metric], numbers: _Numbers, paper: Published) -> Listing:
    """Return one record for each method and column."""
    records: list[tuple[str | int, ...]] = []
    for row in rows:
        for metric in metrics:
            times = numbers[row.identifier][metric.identifier]
            value = plain(times.value, metric.decimals + EXTRA_DECIMALS)
            beside = paper.values.get((row.identifier, BESIDE.get(metric.identifier, "")), "")
            note = "" if times.missing is None else str(times.missing)
            records.append((row.identifier, row.group, metric.identifier, value, beside, note))
    return Listing(FIELDS, tuple(records))
