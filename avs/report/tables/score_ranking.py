"""The ranking table of a data set: do a method's scores put the candidates in the order of the truth?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avs.report.collect import Episodes, read_dataset
from avs.report.document import Cell, Column, Document, Listing
from avs.report.formats.numbers import plain
from avs.report.formats.writing import write_document
from avs.report.methods import Presented, presented
from avs.report.tables.arrangement import arranged
from avs.report.tables.episode_gaps import fewer_seeds, incomplete
from avs.report.tables.episode_notes import own_schedules, repeated_notes
from avs.report.tables.score_ranking_numbers import COLUMNS, Ranking, summarise_ranking
from avs.report.tables.table_notes import missing_notes, scenes_and_seeds, unranked_notes, whole_row
from avs.system.reasons import Reason

FIELDS = ("method", "group", "target", "statistic", "mean", "spread", "over", "scenes", "seeds", "steps", "note")
"""Columns of the csv file."""

_DECIMALS = 4  # of the csv file

_Numbers = Mapping[str, Mapping[str, Ranking]]


def write_ranking_table(
    episodes: Sequence[Path], methods: Sequence[str], dataset: str, out: Path, absent: Mapping[str, Reason]
) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md`` and ``.tex``.

    Equal records give equal bytes, whatever the order of ``episodes``. How each number is computed is described in
    ``docs/tables.md``.

    Args:
        episodes: ``episode.json`` files of the data set.
        methods: see ``score_ranking``.
        dataset: name of the data set.
        out: path of the table without suffix.
        absent: see ``score_ranking``.

    Raises:
        UserError: no episodes; or a record is missing, damaged, of another data set or not comparable with the others.
    """
    write_document(score_ranking(read_dataset(episodes, methods, dataset), methods, absent), out)


def score_ranking(episodes: Episodes, methods: Sequence[str], absent: Mapping[str, Reason]) -> Document:
    """Return the table of rank correlations between scores and truth.

    Args:
        episodes: the episodes of one data set.
        methods: identifiers of the methods, in the order of rows; each has its row, with the reason where it has no
            number.
        absent: why a method could not run, by identifier.
    """
    numbers = summarise_ranking(episodes, methods, absent)
    rows = [presented(method, episodes) for method in methods]
    metrics = [column.metric for column in COLUMNS]
    columns = tuple(Column(metric) for metric in metrics)
    reasons = {method: {metric: each.missing for metric, each in row.items()} for method, row in numbers.items()}
    notes = [
        *missing_notes(episodes, metrics, rows, reasons),
        *_gain_note(episodes),
        *(line for row in rows for line in _left_out_notes(row, numbers[row.identifier])),
    ]
    return Document(
        label=f"ranking-{episodes.dataset}",
        caption=(*incomplete(episodes), *_caption(episodes, numbers)),
        columns=columns,
        groups=arranged(columns, rows, {method: _cells(row) for method, row in numbers.items()}),
        notes=(*dict.fromkeys(notes), *own_schedules(episodes), *repeated_notes(episodes), *unranked_notes(rows)),
        listing=_listing(episodes, rows, numbers),
    )


def _cells(row: Mapping[str, Ranking]) -> list[Cell]:
    whole = whole_row(each.missing for each in row.values())
    return [
        Cell(each.mean, each.spread, cause=whole.cause if whole is not None and index == 0 else None)
        for index, each in enumerate(row.values())
    ]


def _listing(episodes: Episodes, rows: Sequence[Presented], numbers: _Numbers) -> Listing:
    """Return one record for each method and correlation in the order of the table."""
    records: list[tuple[str | int, ...]] = []
    for row in rows:
        fewer = fewer_seeds(episodes, row.identifier)
        for column in COLUMNS:
            each = numbers[row.identifier][column.metric.identifier]
            notes = [*_left_out(each.left_out), *([] if fewer is None else [fewer])]
            if each.missing is not None:
                notes = [str(each.missing)]
            texts = (plain(each.mean, _DECIMALS), plain(each.spread, _DECIMALS), each.over)
            counts = (each.scenes, each.seeds, each.steps)
            records.append(
                (row.identifier, row.group, column.target, column.statistic, *texts, *counts, "; ".join(notes))
            )
    return Listing(FIELDS, tuple(records))


def _caption(episodes: Episodes, numbers: _Numbers) -> list[str]:
    spreads = sorted({each.over for row in numbers.values() for each in row.values() if each.over}, reverse=True)
    sentences = [
        f"Rank correlation of each method's scores with the truth on the data set {episodes.dataset}: "
        f"{', '.join(scenes_and_seeds(episodes))}.",
        "One means that the method would take the candidates in the very order of the truth: lowest SSIM or PSNR "
        "against the hidden photograph first, or highest gain in test PSNR first; zero means no relation.",
        "Mean over selections, scenes and seeds, at the states that the method's own choices led to.",
    ]
    if spreads:
        sentences.append(f"After the plus-minus sign: standard deviation over {' or '.join(spreads)}.")
    return sentences


def _gain_note(episodes: Episodes) -> list[str]:
    """Tell how the gain was measured; all episodes of a table share these settings."""
    truth = episodes.all[0].protocol.get("truth")
    if not isinstance(truth, dict) or truth.get("gain_every") is None:
        return []
    return [
        f"gain: {truth['gain_candidates']} random candidates at one in {truth['gain_every']} selections, from the "
        f"first on; a copy fitted with the candidate against a copy fitted without it, until each view was used "
        f"{_times(truth['gain_passes'])}"
    ]


def _times(number: int) -> str:
    return "once" if number == 1 else f"{number} times"


def _left_out_notes(method: Presented, row: Mapping[str, Ranking]) -> list[str]:
    """Count the selections without a correlation, once for all columns that share the count and the reason."""
    columns: dict[str, list[str]] = {}
    for column in COLUMNS:
        for line in _left_out(row[column.metric.identifier].left_out):
            columns.setdefault(line, []).append(column.metric.name)
    lines = []
    for line, names in columns.items():
        where = "" if len(names) == len(COLUMNS) else f" ({'; '.join(names)})"
        lines.append(f"{method.label}{where}: {line}")
    return lines


def _left_out(reasons: Mapping[str, int]) -> list[str]:
    return [f"{count} selection{'s' if count > 1 else ''} left out, {reason}" for reason, count in reasons.items()]
