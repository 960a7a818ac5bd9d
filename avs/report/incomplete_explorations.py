"""The table of active SLAM of what is there of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from avs.report.collect_explorations import Place, read_explorations
from avs.report.document import Document
from avs.report.tables.active_slam import active_slam
from avs.slam.loop.exploration_record import ExplorationRecord
from avs.slam.scoring.path_settings import PathScorerSettings
from avs.system.errors import UserError
from avs.system.job_logs import why_missing
from avs.system.reasons import Reason
from avs.system.records import read_record


@dataclass(frozen=True)
class WantedExploration:
    """An exploration that a run asks for.

    Attributes:
        place: building, method and seed.
        path: of its record.
        logs: of its job, then of the jobs that it waits for.
        settings: with which it explores; a record of others does not count.
        stale: why the record does not count though it is there, or None.
    """

    place: Place
    path: Path
    logs: tuple[Path, ...]
    settings: Mapping[str, Any]
    stale: str | None = None


@dataclass(frozen=True)
class WantedExplorations:
    """The table of active SLAM.

    Attributes:
        buildings: names, in the order of groups.
        methods: what chooses the paths by identifier, in the order of rows.
        records: what it is made from.
        published: file of the paper's values.
        absent: why a method cannot explore, by identifier.
        absent_buildings: why a building is not explored, by name.
    """

    buildings: tuple[str, ...]
    methods: Mapping[str, PathScorerSettings]
    records: tuple[WantedExploration, ...]
    published: Path
    absent: Mapping[str, Reason]
    absent_buildings: Mapping[str, Reason]


def incomplete_explorations(wanted: WantedExplorations) -> Document:
    """Return the table of what is there, with the reason for what is not.

    Raises:
        UserError: there is no record, or records cannot be compared.
    """
    reasons = {each.place: _why_not(each) for each in wanted.records}
    missing = {place: why for place, why in reasons.items() if why is not None}
    paths = [each.path for each in wanted.records if each.place not in missing]
    if not paths:
        told = dict.fromkeys(missing.values())
        raise UserError("table of active SLAM", "no exploration yet", "; ".join(told) or "go on with the run")
    explorations = replace(read_explorations(paths), missing=missing)
    absent = wanted.absent, wanted.absent_buildings
    return active_slam(explorations, wanted.buildings, wanted.methods, wanted.published, *absent)


def _why_not(wanted: WantedExploration) -> str | None:
    """Return why a record is not there or does not count, or None if it does."""
    if not wanted.path.exists():
        return why_missing(wanted.logs)
    try:
        record = read_record(wanted.path, ExplorationRecord)
    except UserError as error:
        return str(error)
    return "it was run with other settings" if record.settings != wanted.settings else wanted.stale
