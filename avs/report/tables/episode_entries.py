"""What tables of episodes share beside their numbers: the cells of a row, and the records of the csv file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avs.report.collect import Episodes
from avs.report.document import Cell, Listing
from avs.report.formats.numbers import EXTRA_DECIMALS, plain
from avs.report.methods import Presented
from avs.report.tables.episode_gaps import fewer_seeds
from avs.report.tables.episode_notes import notes_of_method
from avs.report.tables.table_notes import count, whole_row
from avs.report.tables.view_synthesis_numbers import Entry
from metrics.definitions import Metric

FIELDS = ("method", "group", "metric", "mean", "spread", "scenes", "seeds", "published", "difference", "note")
"""Columns of the csv file."""

Numbers = Mapping[str, Mapping[str, Entry]]
"""What ``view_synthesis_numbers.summarise_episodes`` returns."""


def entry_cells(
    columns: Sequence[Metric], method: str, row: Mapping[str, Entry], published: Mapping[tuple[str, str], str]
) -> list[Cell]:
    """Return the cells of a method's row, with the paper's values by identifier of the method and of the metric."""
    whole = whole_row(entry.missing for entry in row.values())
    return [
        Cell(
            value=entry.mean,
            spread=entry.spread,
            published=published.get((method, metric.identifier)),
            cause=whole.cause if whole is not None and index == 0 else None,
        )
        for index, (metric, entry) in enumerate(zip(columns, row.values(), strict=True))
    ]


def has_spread(numbers: Numbers) -> bool:
    """Return whether any entry has a spread over seeds."""
    return any(entry.spread is not None for row in numbers.values() for entry in row.values())


def entry_listing(
    columns: Sequence[Metric],
    episodes: Episodes,
    rows: Sequence[Presented],
    numbers: Numbers,
    cells: Mapping[str, Sequence[Cell]],
    has_difference: bool,
) -> Listing:
    """Return one record for each method and metric in the order of the table."""
    records: list[tuple[str | int, ...]] = []
    with_spread = has_spread(numbers)
    for row in rows:
        for metric, cell in zip(columns, cells[row.identifier], strict=True):
            entry, digits = numbers[row.identifier][metric.identifier], metric.decimals + EXTRA_DECIMALS
            notes = _notes(episodes, row.identifier, entry, with_spread)
            texts = (plain(entry.mean, digits), plain(entry.spread, digits))
            paper = (cell.published or "", plain(cell.difference if has_difference else None, digits))
            counts = (entry.scenes, entry.seeds)
            records.append((row.identifier, row.group, metric.identifier, *texts, *counts, *paper, "; ".join(notes)))
    return Listing(FIELDS, tuple(records))


def _notes(episodes: Episodes, method: str, entry: Entry, with_spread: bool) -> list[str]:
    if entry.missing is not None:
        return [str(entry.missing)]
    notes = []
    if entry.spread is None and with_spread:
        notes.append(f"no spread of {count(entry.seeds, 'seed')}")
    if (fewer := fewer_seeds(episodes, method)) is not None:
        notes.append(fewer)
    # A deviation of one scene, such as a capped budget, concerns the mean of every metric.
    return notes + notes_of_method(episodes, method)
