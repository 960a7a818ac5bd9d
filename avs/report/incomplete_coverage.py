"""The coverage table of what is there of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avs.coverage.coverage_record import Coverage
from avs.nvs.record import Episode
from avs.report.collect import Cell, Episodes
from avs.report.collect_coverage import read_coverages, why_other, with_coverage
from avs.report.document import Document
from avs.report.tables.scene_coverage import scene_coverage
from avs.system.errors import UserError
from avs.system.job_logs import why_missing
from avs.system.reasons import Reason
from avs.system.records import read_record


@dataclass(frozen=True)
class WantedCoverage:
    """The coverage of one episode.

    Attributes:
        method: identifier.
        cell: scene and seed.
        path: of its record.
        logs: of its job, then of the jobs that it waits for.
        stale: why the record does not count though it is there, or None.
    """

    method: str
    cell: Cell
    path: Path
    logs: tuple[Path, ...]
    stale: str | None = None


@dataclass(frozen=True)
class WantedCoverageTable:
    """The coverage table of one data set.

    Attributes:
        dataset: its name.
        methods: identifiers of the rows, in order.
        records: what it is made from.
        settings: with which a record is measured; one of others does not count.
        published: file of the paper's values, or None.
        lacking: why there is no coverage at all, or None.
    """

    dataset: str
    methods: tuple[str, ...]
    records: tuple[WantedCoverage, ...]
    settings: Mapping[str, Any]
    published: Path | None
    lacking: Reason | None


def incomplete_coverage(
    wanted: WantedCoverageTable,
    episodes: Episodes,
    absent: Mapping[str, Reason],
    reference: str | None,
) -> Document:
    """Return the table of what is there, with the reason for what is not.

    Args:
        wanted: what the table is made from.
        episodes: of the data set, as far as they are there.
        absent: why a method could not run, by identifier.
        reference: identifier of the method that the others are compared with, or None.

    Raises:
        UserError: there is no record, although the back end is here; or records cannot be compared.
    """
    reasons: dict[str, dict[Cell, str]] = {}
    paths = []
    for each in wanted.records if wanted.lacking is None else ():
        episode = episodes.cells.get(each.method, {}).get(each.cell)
        why = None if episode is None else _why_not(each, episode, wanted.settings)
        if why is not None:
            reasons.setdefault(each.method, {})[each.cell] = why
        elif episode is not None:
            paths.append(each.path)
    if not paths and wanted.lacking is None:
        told = dict.fromkeys(why for cells in reasons.values() for why in cells.values())
        raise UserError(f"coverage of {wanted.dataset}", "no record yet", "; ".join(told) or "go on with the run")
    coverages = read_coverages(paths, episodes, wanted.lacking)
    there = episodes if wanted.lacking is not None else with_coverage(episodes, coverages, reasons)
    return scene_coverage(there, coverages, wanted.methods, wanted.published, absent, reference)


def _why_not(wanted: WantedCoverage, episode: Episode, settings: Mapping[str, Any]) -> str | None:
    """Return why a record is not there or does not count, or None if it does."""
    if not wanted.path.exists():
        return f"no coverage: {why_missing(wanted.logs)}"
    try:
        record = read_record(wanted.path, Coverage)
    except UserError as error:
        return str(error)
    if record.settings != settings:
        return "its coverage was measured with other settings"
    other = why_other(record, episode)
    if other is not None:
        return f"its coverage {other}"
    return None if wanted.stale is None else f"its coverage does not count: {wanted.stale}"
