"""The table of selection times: all that is measured of one selection, with the paper's values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avs.nvs.timing_record import Runtime
from avs.report.collect import Episodes
from avs.report.document import Cell, Column, Document, Listing
from avs.report.formats.numbers import EXTRA_DECIMALS, plain
from avs.report.formats.writing import write_document
from avs.report.methods import Presented, presented_in_columns
from avs.report.published import read_published
from avs.report.tables.arrangement import arranged
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

FIELDS = ("method", "group", "metric", "value", "lowest", "highest", "repeats", "published", "note")
"""Columns of the csv file."""

PUBLISHED_SCENE = "garden"
"""The scene of the paper's two tables of times."""

# The paper's values stand in columns of their own, without a difference, under the names that its files give them.
_PUBLISHED_COLUMNS = (
    Metric("psnr", "paper: PSNR", None, 2, "dB", "the paper's PSNR"),
    Metric("selection_seconds", "paper: selection", None, 2, "s", "the paper's time of one selection"),
    Metric("gpu_memory_gb", "paper: GPU memory", None, 1, "GB", "the paper's peak memory"),
)
BESIDE = {"psnr": "psnr", "selection_seconds": "selection_seconds", "peak_memory_gb": "gpu_memory_gb"}
"""What the paper's files call a column of this table."""

_Numbers = Mapping[str, Mapping[str, Times]]
_Paper = Mapping[tuple[str, str], str]


def write_runtime_table(
    records: Sequence[Path],
    episodes: Sequence[Path],
    methods: Sequence[str],
    absent: Mapping[str, Reason],
    published: Sequence[Path],
    out: Path,
) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md`` and ``.tex``.

    Args:
        records: ``avs.nvs.timing_record.Runtime`` files, at most one for each method, all of one scene.
        episodes: ``episode.json`` files of that scene, for the PSNR.
        methods: see ``selection_times``.
        absent: see ``selection_times``.
        published: see ``selection_times``.
        out: path of the table without suffix.

    Raises:
        UserError: a record is missing, damaged, or not comparable with the others; or the published values cannot be
            read.
    """
    timed = read_runtimes(records)
    collected = episodes_of_scene(episodes, methods, timed)
    write_document(selection_times(timed, collected, methods, absent, published), out)


def selection_times(
    records: Mapping[str, Runtime],
    episodes: Episodes,
    methods: Sequence[str],
    absent: Mapping[str, Reason],
    published: Sequence[Path],
    untimed: int = 0,
) -> Document:
    """Return the table of what one selection costs.

    Args:
        records: selection times by method, at least one.
        episodes: on the scene that they were measured on, for the PSNR.
        methods: identifiers of the methods, in the order of rows; each has its row, with the reason where it was not
            timed.
        absent: why a method is not timed, by identifier.
        published: files of ``results/published`` with the paper's times.
        untimed: number of methods whose times a run has asked for and does not have.

    Raises:
        UserError: the published values cannot be read.
    """
    paper = {key: text for path in published for key, text in read_published(path, PUBLISHED_SCENE).values.items()}
    metrics = [*COLUMNS, *(_PUBLISHED_COLUMNS if paper else ())]
    numbers = summarise_runtime(records, episodes, methods, absent)
    rows = [presented_in_columns(method, [episodes]) for method in methods]
    ordered = [records[method] for method in methods if method in records]
    columns = tuple(map(Column, ranked_times(metrics, ordered)))
    cells = {method: _cells(method, numbers[method], paper, episodes) for method in methods}
    return Document(
        label=f"runtime-{ordered[0].scene}",
        caption=(*untimed_methods(episodes, untimed), *timing_caption(ordered)),
        columns=columns,
        groups=arranged(columns, rows, cells),
        notes=tuple(timing_notes(rows, numbers, ordered, episodes, has_paper=bool(paper))),
        listing=_listing(rows, numbers, paper),
    )


def _cells(method: str, row: Mapping[str, Times], paper: _Paper, episodes: Episodes) -> list[Cell]:
    whole = whole_row(times.missing for times in row.values())
    cells = [
        Cell(
            times.value,
            cause=whole.cause if whole is not None and index == 0 else None,
            ranked=is_ranked(name, method, episodes),
        )
        for index, (name, times) in enumerate(row.items())
    ]
    texts = [paper.get((method, metric.identifier)) for metric in _PUBLISHED_COLUMNS] if paper else []
    return cells + [Cell(None if text is None else float(text)) for text in texts]


def _listing(rows: Sequence[Presented], numbers: _Numbers, paper: _Paper) -> Listing:
    """Return one record for each method and column.

    ``value`` is the median over the timed selections, ``lowest`` and ``highest`` their range.
    """
    records: list[tuple[str | int, ...]] = []
    for row in rows:
        for metric in COLUMNS:
            times = numbers[row.identifier][metric.identifier]
            digits = metric.decimals + EXTRA_DECIMALS if metric.decimals else 0
            ends = (min(times.values), max(times.values)) if len(times.values) > 1 else (None, None)
            texts = (plain(number, digits) for number in (times.value, *ends))
            published = paper.get((row.identifier, BESIDE.get(metric.identifier, "")), "")
            note = "" if times.missing is None else str(times.missing)
            records.append((row.identifier, row.group, metric.identifier, *texts, len(times.values), published, note))
    return Listing(FIELDS, tuple(records))
