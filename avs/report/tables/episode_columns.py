"""What tables share in which each column has the episodes of all methods under settings, or on a representation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avs.report.collect import Cell, Episodes, end_of_curve, image_mean, read_dataset
from avs.report.document import Listing
from avs.report.formats.numbers import plain
from avs.report.methods import Presented, presented
from avs.report.tables.episode_notes import own_schedules, own_settings, repeated_notes
from avs.report.tables.setting_sensitivity_numbers import Standing
from avs.selection.contract import UNRANKED
from avs.system.errors import UserError

PER_EPISODE = "_per_episode"
"""What ends the name of the csv file of single episodes."""

_EPISODE_FIELDS = ("column", "method", "metric", "scene", "seed", "value")
_DECIMALS = 4

Columns = Mapping[str, Episodes]
"""Episodes by the name of the column."""

Standings = Mapping[str, Mapping[str, Standing]]
"""Each method's standing, by the name of the column and the method's identifier."""


def read_columns(records: Mapping[str, Sequence[Path]], methods: Sequence[str], dataset: str) -> dict[str, Episodes]:
    """Read ``episode.json`` files by the name of the column; a column may have none.

    Raises:
        UserError: a record is damaged, of another data set, or cannot be compared with others of its column.
    """
    return {
        name: read_dataset(paths, methods, dataset) if paths else Episodes(dataset, {})
        for name, paths in records.items()
    }


def check_scenes(columns: Columns) -> None:
    """Look whether all columns have the same scenes.

    Raises:
        UserError: there are episodes on different versions of a scene.
    """
    hashes: dict[str, str] = {}
    for name, episodes in columns.items():
        for episode in episodes.all:
            if hashes.setdefault(episode.scene, episode.scene_hash) != episode.scene_hash:
                fault = f"was run on another version of the scene {episode.scene} than others"
                raise UserError(f"{name}, {episode.method}", fault, "run all of them again")


def places_of(columns: Columns) -> list[Cell]:
    """Return every scene and seed that any method has, or should have, in any column."""
    found = (cells for each in columns.values() for cells in (*each.cells.values(), *each.missing.values()))
    return sorted({place for cells in found for place in cells})


def single_values(columns: Columns, methods: Sequence[str]) -> Listing:
    """Return the PSNR at the end of each episode, mean over its test images, for other programs."""
    records = [
        (name, method, "psnr", *cell, plain(image_mean(end_of_curve(episode), "psnr"), _DECIMALS))
        for name, episodes in columns.items()
        for method in methods
        for cell, episode in sorted(episodes.cells.get(method, {}).items())
    ]
    return Listing(_EPISODE_FIELDS, tuple(records))


def incomplete(found: Standings) -> list[str]:
    """Return the sentence of a caption about missing means, if any is."""
    missing = sum(each.missing is not None for row in found.values() for each in row.values())
    return [f"Incomplete: {missing} of {sum(map(len, found.values()))} means are missing."] if missing else []


def missing_means(rows: Sequence[Presented], found: Standings) -> list[str]:
    """Return a line for each method and reason why it has no mean, with the columns unless it is all of them."""
    lines = []
    for row in rows:
        reasons: dict[str, list[str]] = {}
        for name, column in found.items():
            missing = column[row.identifier].missing
            if missing is not None:
                reasons.setdefault(str(missing), []).append(name)
        for reason, names in reasons.items():
            where = "" if len(names) == len(found) else f" ({', '.join(names)})"
            lines.append(f"{row.label}{where}: {reason}")
    return lines


def told_by_columns(columns: Columns, rows: Sequence[Presented]) -> list[str]:
    """Return the notes of the records and what else sets some episodes apart, with the columns unless it is all.

    A method may compete in one column and have a schedule of its own in another.
    """
    lines: dict[str, list[str]] = {}
    having = {name: episodes for name, episodes in columns.items() if episodes.all}
    for name, episodes in having.items():
        apart = [*_unranked(episodes, rows), *own_schedules(episodes), *own_settings(episodes)]
        for line in dict.fromkeys([*apart, *repeated_notes(episodes)]):
            lines.setdefault(line, []).append(name)
    return [line if len(names) == len(having) else f"{', '.join(names)}: {line}" for line, names in lines.items()]


def _unranked(episodes: Episodes, rows: Sequence[Presented]) -> list[str]:
    """Return why methods whose rows compete do not do so here."""
    here = [(row, presented(row.identifier, episodes)) for row in rows if row.competes]
    return [f"{row.label}: {UNRANKED[each.group]}" for row, each in here if not each.competes]
