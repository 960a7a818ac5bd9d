"""Writes the ranking table of a data set from its episode records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avs.report.collect import own_settings, read_dataset
from avs.report.formats import latex, markdown
from avs.report.formats.delimited import csv_text
from avs.report.formats.wording import missing, oracle_note, scenes_and_seeds
from avs.report.tables.rank_correlation import COLUMNS, Column, Ranking, summarise_ranking
from avs.report.tables.summary import Row
from avs.report.tables.view_synthesis import with_ending
from avs.system.files import write_text
from avs.system.reasons import Reason

FIELDS = ("method", "group", "target", "statistic", "mean", "spread", "over", "scenes", "seeds", "steps", "note")
"""Columns of the csv file."""

_DECIMALS = 4


def write_ranking_table(
    episodes: Sequence[Path], methods: Sequence[str], dataset: str, out: Path, absent: Mapping[str, Reason]
) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md`` and ``.tex``.

    Equal records give equal bytes, whatever the order of ``episodes``. How each number is computed is described in
    ``docs/tables.md``.

    Args:
        episodes: ``episode.json`` files of the data set.
        methods: identifiers of the methods, in the order of rows; each has its row, with the reason where it has no
            number.
        dataset: name of the data set.
        out: path of the table without suffix.
        absent: why a method could not run, with the remedy, by identifier.

    Raises:
        UserError: no episodes; or a record is missing, damaged, of another data set or not comparable with the others.
    """
    ranking = summarise_ranking(read_dataset(episodes, methods, dataset), methods, absent)
    write_text(with_ending(out, ".csv"), ranking_csv(ranking))
    write_text(with_ending(out, ".md"), ranking_markdown(ranking))
    write_text(with_ending(out, ".tex"), ranking_latex(ranking))


def ranking_csv(ranking: Ranking) -> str:
    """Return one row per method and correlation in the order of the table; an empty field is a missing value."""
    rows = [_csv_row(ranking, row, column) for row in ranking.table.rows for column in COLUMNS]
    return csv_text(FIELDS, rows)


def ranking_markdown(ranking: Ranking) -> str:
    """Return the caption, the table and the notes."""
    sentences = [*_caption(ranking), "Best in bold, second and third numbered."]
    return markdown.document([" ".join(sentences), markdown.grid(ranking.table)], _notes(ranking))


def ranking_latex(ranking: Ranking) -> str:
    """Return a ``table*`` environment: caption, label, the table and the notes."""
    dataset = ranking.table.episodes.dataset
    return latex.environment("ranking", dataset, _caption(ranking), latex.grid(ranking.table), _notes(ranking))


def _csv_row(ranking: Ranking, row: Row, column: Column) -> tuple[object, ...]:
    entry, detail = row.entries[column.metric.identifier], ranking.details[row.method, column.metric.identifier]
    notes = [str(entry.missing)] if entry.missing is not None else _left_out(detail.left_out)
    numbers = ("" if value is None else f"{value:.{_DECIMALS}f}" for value in (entry.mean, entry.spread))
    counts = (detail.over, entry.scenes, entry.seeds, detail.steps)
    return (row.method, row.group, column.target, column.statistic, *numbers, *counts, "; ".join(notes))


def _caption(ranking: Ranking) -> list[str]:
    episodes = ranking.table.episodes
    spreads = sorted({detail.over for detail in ranking.details.values() if detail.over}, reverse=True)
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


def _notes(ranking: Ranking) -> list[str]:
    lines = [*missing(ranking.table), *_gain(ranking)]
    for row in ranking.table.rows:
        columns: dict[str, list[str]] = {}
        for column in COLUMNS:
            for line in _left_out(ranking.details[row.method, column.metric.identifier].left_out):
                columns.setdefault(line, []).append(column.metric.name)
        for line, names in columns.items():
            where = "" if len(names) == len(COLUMNS) else f" ({'; '.join(names)})"
            lines.append(f"{row.label}{where}: {line}")
    return [*dict.fromkeys(lines), *oracle_note(ranking.table), *own_settings(ranking.table.episodes)]


def _gain(ranking: Ranking) -> list[str]:
    """Tell how the gain was measured; all episodes of a table share these settings."""
    truth = ranking.table.episodes.all[0].protocol.get("truth")
    if not isinstance(truth, dict) or truth.get("gain_every") is None:
        return []
    return [
        f"gain: {truth['gain_candidates']} random candidates at one in {truth['gain_every']} selections, from the "
        f"first on; a copy fitted with the candidate against a copy fitted without it, until each view was used "
        f"{_times(truth['gain_passes'])}"
    ]


def _times(number: int) -> str:
    return "once" if number == 1 else f"{number} times"


def _left_out(reasons: Mapping[str, int]) -> list[str]:
    return [f"{count} selection{'s' if count > 1 else ''} left out, {reason}" for reason, count in reasons.items()]
