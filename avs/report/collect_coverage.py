"""Records of coverage read for a table or figure, checked to be those of its episodes and comparable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from avs.coverage.coverage_record import Coverage, CoverageMeta, Numbers
from avs.coverage.episode_coverage import views_of
from avs.nvs.record import Episode
from avs.report.collect import Cell, Episodes
from avs.report.machines import machine_notes
from avs.system.errors import UserError
from avs.system.reasons import Reason
from avs.system.records import read_record

_REMEDY = "run the job that makes it again"


@dataclass(frozen=True)
class Coverages:
    """The coverage of the episodes of one data set.

    Attributes:
        cells: by method, then by scene and seed.
        lacking: why there is none at all, such as a back end that is not installed; or None.
        records: the files.
    """

    cells: Mapping[str, Mapping[Cell, Coverage]]
    lacking: Reason | None = None
    records: Sequence[Path] = ()

    @property
    def all(self) -> list[Coverage]:
        """Every record, by method, scene and seed."""
        return [record for cells in self.cells.values() for record in cells.values()]

    def record(self, method: str, cell: Cell) -> Coverage | None:
        """Return the record of an episode, or None if there is none."""
        return self.cells.get(method, {}).get(cell)

    def numbers(self, method: str, cell: Cell, *, true: bool) -> Numbers | None:
        """Return what an episode's record says against the reference, or against the true surface."""
        record = self.record(method, cell)
        if record is None:
            return None
        return record.against_surface if true else record.against_reference


def read_coverages(paths: Sequence[Path], episodes: Episodes, lacking: Reason | None = None) -> Coverages:
    """Read the records at ``paths``, one for each episode.

    Args:
        paths: ``coverage.json`` files.
        episodes: of the data set.
        lacking: why there is none at all, or None.

    Raises:
        UserError: a record is missing, damaged, repeats another, is not of one of the episodes as it is now, or was
            measured with other settings than the others.
    """
    cells: dict[str, dict[Cell, Coverage]] = {}
    first: Coverage | None = None
    for path in paths:
        record = read_record(path, Coverage)
        cell = (record.scene, record.seed)
        if cell in cells.get(record.method, {}):
            raise UserError(path, "repeats another record", "pass one for each method, scene and seed")
        fault = why_other(record, episodes.cells.get(record.method, {}).get(cell))
        if record.dataset != episodes.dataset or fault is not None:
            raise UserError(path, fault or f"is of the data set {record.dataset}", _REMEDY)
        first = first or record
        if (record.settings, record.reference) != (first.settings, first.reference):
            raise UserError(path, "was measured with other settings than others", _REMEDY)
        cells.setdefault(record.method, {})[cell] = record
    return Coverages({method: dict(sorted(found.items())) for method, found in cells.items()}, lacking, tuple(paths))


def coverage_machine_notes(records: Sequence[Path]) -> list[str]:
    """Return a line for each fact of machine or packages that differs between records; see ``machine_notes``."""
    return machine_notes(records, CoverageMeta, "records of coverage")


def paths_by_dataset(paths: Sequence[Path]) -> dict[str, list[Path]]:
    """Return the paths of records by their data set.

    Raises:
        UserError: a record is missing or damaged.
    """
    found: dict[str, list[Path]] = {}
    for path in paths:
        found.setdefault(read_record(path, Coverage).dataset, []).append(path)
    return found


def why_other(record: Coverage, episode: Episode | None) -> str | None:
    """Return why a record is not of this episode, or None if it is."""
    if episode is None:
        return "is of an episode that is not here"
    if record.scene_hash != episode.scene_hash:
        return "is of another version of the scene than the episode"
    return None if record.views == views_of(episode) else "is of other views than the episode's"


def with_coverage(episodes: Episodes, coverages: Coverages, reasons: Mapping[str, Mapping[Cell, str]]) -> Episodes:
    """Return the episodes that have a record of coverage; the others count as missing, with their reasons.

    Args:
        episodes: of the data set.
        coverages: of some of them.
        reasons: why an episode has none, by method, scene and seed.
    """
    cells = {
        method: {cell: episode for cell, episode in found.items() if coverages.record(method, cell) is not None}
        for method, found in episodes.cells.items()
    }
    missing = {
        method: {**episodes.missing.get(method, {}), **reasons.get(method, {})}
        for method in dict.fromkeys((*episodes.missing, *reasons))
    }
    found = {method: each for method, each in cells.items() if each}
    return replace(episodes, cells=found, missing=missing, counted=("record of coverage", "records of coverage"))
