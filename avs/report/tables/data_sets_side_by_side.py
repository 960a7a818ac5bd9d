"""View synthesis on several data sets in one table, as the paper has RealEstate10K and Map-Free."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from avs.report.collect import Episodes
from avs.report.document import Cell, Document, Listing
from avs.report.formats.writing import write_document
from avs.report.machines import machine_notes
from avs.report.methods import Presented, presented, presented_in_columns
from avs.report.published import Published, called, headed, published_note, read_published
from avs.report.tables.arrangement import arranged
from avs.report.tables.episode_columns import told_by_columns
from avs.report.tables.episode_entries import FIELDS, Numbers, entry_cells, entry_listing, has_spread
from avs.report.tables.episode_gaps import incomplete
from avs.report.tables.published_columns import published_column, why_no_mean_difference
from avs.report.tables.reconstruction_facts import column_facts
from avs.report.tables.table_notes import missing_notes, no_scenes, scenes_and_seeds, spread_note, unranked_notes
from avs.report.tables.view_synthesis_numbers import COLUMNS, summarise_episodes
from avs.system.reasons import Reason


@dataclass(frozen=True)
class ShownDataSet:
    """One data set of the table.

    Attributes:
        episodes: its episodes.
        methods: identifiers of its methods, in the order of rows.
        absent: why a method could not run, by identifier.
        published: a file of ``results/published``, or None.
        pictures: settings of the size of images and of the split, as far as they are known.
        left_out: why something that looks like a scene is none, by its name.
    """

    episodes: Episodes
    methods: Sequence[str]
    absent: Mapping[str, Reason]
    published: Path | None
    pictures: Mapping[str, Any] = field(default_factory=dict)
    left_out: Mapping[str, Reason] = field(default_factory=dict)


@dataclass(frozen=True)
class _Numbers:
    """What is printed of one data set."""

    shown: ShownDataSet
    entries: Numbers
    paper: Published | None
    why_not: str | None


def write_side_by_side_table(sets: Sequence[ShownDataSet], out: Path) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md`` and ``.tex``; equal records give equal bytes.

    Raises:
        UserError: the published values cannot be read.
    """
    write_document(side_by_side(sets, out.name), out)


def side_by_side(sets: Sequence[ShownDataSet], label: str) -> Document:
    """Return the table: the means of each data set in columns of their own, a row for each method of any of them.

    Args:
        sets: the data sets, in the order of columns.
        label: identifier of the table.

    Raises:
        UserError: the published values cannot be read.
    """
    found = [_numbers(each) for each in sets]
    methods = dict.fromkeys(method for each in sets for method in each.methods)
    rows = [presented_in_columns(method, [each.episodes for each in sets]) for method in methods]
    columns = tuple(
        published_column(metric, each.paper, each.why_not, over=headed(each.shown.episodes.dataset))
        for each in found
        for metric in COLUMNS
    )
    cells = {row.identifier: [cell for each in found for cell in _cells(each, row.identifier)] for row in rows}
    notes = [
        *_by_data_set((each.shown.episodes.dataset, _missing(each, rows)) for each in found),
        *_by_data_set((each.episodes.dataset, spread_note(each.episodes, each.methods)) for each in sets),
        *_by_data_set((each.episodes.dataset, no_scenes(each.left_out)) for each in sets),
        *(published_note(each.paper.dataset, each.why_not) for each in found if each.paper is not None),
        *machine_notes([path for each in sets for path in each.episodes.records]),
        *told_by_columns({each.episodes.dataset: each.episodes for each in sets}, rows),
        *unranked_notes(rows),
    ]
    return Document(
        label=label.replace("_", "-"),
        caption=tuple(_caption(found)),
        columns=columns,
        groups=arranged(columns, rows, cells),
        notes=tuple(dict.fromkeys(notes)),
        listing=_listing(found, rows),
    )


def _numbers(shown: ShownDataSet) -> _Numbers:
    paper = None if shown.published is None else read_published(shown.published)
    why_not = None if paper is None else why_no_mean_difference(paper, shown.episodes, shown.pictures)
    return _Numbers(shown, summarise_episodes(shown.episodes, shown.methods, None, shown.absent), paper, why_not)


def _cells(numbers: _Numbers, method: str) -> list[Cell]:
    """Return the cells of a method in the columns of one data set; empty ones where it is no method of it."""
    if method not in numbers.entries:
        return [Cell() for _ in COLUMNS]
    beside = {} if numbers.paper is None else numbers.paper.values
    ranked = presented(method, numbers.shown.episodes).ranked
    return [replace(cell, ranked=ranked) for cell in entry_cells(COLUMNS, method, numbers.entries[method], beside)]


def _of(numbers: _Numbers, rows: Sequence[Presented]) -> list[Presented]:
    return [row for row in rows if row.identifier in numbers.entries]


def _missing(numbers: _Numbers, rows: Sequence[Presented]) -> list[str]:
    reasons = {method: {name: entry.missing for name, entry in row.items()} for method, row in numbers.entries.items()}
    return missing_notes(numbers.shown.episodes, COLUMNS, _of(numbers, rows), reasons)


def _by_data_set(notes: Iterable[tuple[str, Sequence[str]]]) -> list[str]:
    """Return each note once; behind the names of its data sets, unless it is one of all of them."""
    places: dict[str, list[str]] = {}
    names = []
    for name, lines in notes:
        names.append(name)
        for line in lines:
            places.setdefault(line, []).append(name)
    return [line if found == names else f"{', '.join(found)}: {line}" for line, found in places.items()]


def _caption(found: Sequence[_Numbers]) -> list[str]:
    sets = [each.shown.episodes for each in found]
    told = "; ".join(f"{called(each.dataset)}, with {', '.join(scenes_and_seeds(each))}" for each in sets)
    gaps = [f"{each.dataset}: {sentence}" for each in sets for sentence in incomplete(each)]
    sentences = [
        *gaps,
        f"Active view selection on {len(sets)} data sets: {told}.",
        *column_facts({each.dataset: each for each in sets}),
        "Test images at the end of the optimisation; mean over seeds of the mean over scenes.",
    ]
    if any(has_spread(each.entries) for each in found):
        sentences.append("After the plus-minus sign: standard deviation over seeds of the mean over scenes.")
    named = " and ".join(f"nvs_{each.dataset}" for each in sets)
    return [*sentences, f"Marks rank the printed means, whatever their intervals, which are in the tables {named}."]


def _listing(found: Sequence[_Numbers], rows: Sequence[Presented]) -> Listing:
    """Return the records of the table of each data set, behind its name."""
    records: list[tuple[str | int, ...]] = []
    for each in found:
        episodes, own = each.shown.episodes, _of(each, rows)
        cells = {row.identifier: _cells(each, row.identifier) for row in own}
        subtracted = each.paper is not None and each.why_not is None
        listing = entry_listing(COLUMNS, episodes, own, each.entries, cells, has_difference=subtracted)
        records += [(episodes.dataset, *record) for record in listing.records]
    return Listing(("dataset", *FIELDS), tuple(records))
