"""What the tables of a run are made from: its records, whether they are there or not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from avs.report.collect import Cell
from avs.report.incomplete_coverage import WantedCoverageTable
from avs.report.incomplete_explorations import WantedExplorations
from avs.report.incomplete_scorers import WantedScorers
from avs.report.tables.runtime_summary import Summary
from avs.system.reasons import Reason


@dataclass(frozen=True)
class WantedRecord:
    """A record that a run asks for.

    Attributes:
        method: identifier.
        path: where it is written.
        scene: ``scene.json`` of its scene; a record of another version of the scene does not count.
        logs: of its job, then of the jobs that it waits for.
        stale: why the record does not count though it is there, such as a change of code, or None.
    """

    method: str
    path: Path
    scene: Path
    logs: tuple[Path, ...]
    stale: str | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class WantedEpisode(WantedRecord):
    """An episode that a run asks for.

    Attributes:
        cell: its scene and seed.
        settings: fields of its record, such as the protocol, that must have these values; a record of another
            configuration does not count.
    """

    cell: Cell
    settings: Mapping[str, Any]


@dataclass(frozen=True)
class WantedStates:
    """The record of the common states of one scene and seed; see ``WantedEpisode``."""

    path: Path
    scene: Path
    logs: tuple[Path, ...]
    cell: Cell
    settings: Mapping[str, Any]
    stale: str | None = None


@dataclass(frozen=True)
class WantedTable:
    """The view synthesis and the ranking table of one data set.

    Attributes:
        dataset: its name.
        methods: identifiers of the rows, in order.
        episodes: what the first is made from.
        published: file of the paper's values, or None.
        states: what the second is made from; none if the run leaves it out.
        unscored: why a method has no scores in it, by identifier.
        left_out: why something that looks like a scene is none, by its name.
        pictures: settings of the size of images and of the split, as far as they are known.
        published_scenes: files of the paper's values of its single scenes and their means.
    """

    dataset: str
    methods: tuple[str, ...]
    episodes: tuple[WantedEpisode, ...]
    published: Path | None
    states: tuple[WantedStates, ...] = ()
    unscored: Mapping[str, Reason] = field(default_factory=dict)
    left_out: Mapping[str, Reason] = field(default_factory=dict)
    pictures: Mapping[str, Any] = field(default_factory=dict)
    published_scenes: tuple[Path, ...] = ()


@dataclass(frozen=True)
class WantedSensitivity:
    """The sensitivity table of one data set.

    Attributes:
        dataset: its name.
        methods: identifiers of the rows, in order.
        settings: the episodes under each of the settings, by its name; the run's own come first, as ``BASE``.
    """

    dataset: str
    methods: tuple[str, ...]
    settings: Mapping[str, tuple[WantedEpisode, ...]]


@dataclass(frozen=True)
class WantedAgnostic:
    """The table of several representations of one data set.

    Attributes:
        dataset: its name.
        methods: identifiers of the rows, in order.
        representations: the episodes on each of them, by its name.
        absent: why a method could not run, by representation and method.
    """

    dataset: str
    methods: tuple[str, ...]
    representations: Mapping[str, tuple[WantedEpisode, ...]]
    absent: Mapping[str, Mapping[str, Reason]]


@dataclass(frozen=True)
class WantedTimes:
    """The table of selection times.

    Attributes:
        dataset: the data set of the scene.
        methods: identifiers of the rows, in order.
        scene: the scene on which methods are timed.
        records: one for each method that is timed.
        absent: why another is not, by identifier.
        published: files of the paper's times.
        summaries: the rows of each table in the paper's layout, and the file of the paper's values, by the table.
    """

    dataset: str
    methods: tuple[str, ...]
    scene: str
    records: tuple[WantedRecord, ...]
    absent: Mapping[str, Reason]
    published: tuple[Path, ...]
    summaries: Mapping[Summary, tuple[tuple[str, ...], Path]] = field(default_factory=dict)


@dataclass(frozen=True)
class UnfinishedRun:
    """All that the tables of a run are made from.

    Attributes:
        reference: the method that the others are compared with, or None.
        absent: why a method could not run, by identifier.
        tables: for each data set.
        times: the selection times, or None if the run leaves them out.
        sensitivity: the sensitivity table of each data set; none if the run leaves them out.
        coverage: the coverage table of each data set; none if the run leaves them out.
        side_by_side: the data sets that one table has side by side; none if there is no such table.
        explorations: what the table of active SLAM is made from, or None if the run leaves it out.
        agnostic: the table of several representations of each data set; none if the run leaves them out.
        scorers: what the table of scorers is made from, or None if the run leaves it out.
    """

    reference: str | None
    absent: Mapping[str, Reason]
    tables: tuple[WantedTable, ...]
    times: WantedTimes | None
    sensitivity: tuple[WantedSensitivity, ...] = ()
    coverage: tuple[WantedCoverageTable, ...] = ()
    side_by_side: tuple[str, ...] = ()
    explorations: WantedExplorations | None = None
    agnostic: tuple[WantedAgnostic, ...] = ()
    scorers: WantedScorers | None = None
