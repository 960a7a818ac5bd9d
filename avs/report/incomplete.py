"""Tables of what a run has so far, each with its gaps and their causes."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from avs.nvs.common_states_record import CommonStates
from avs.nvs.record import Episode
from avs.nvs.timing_record import Runtime
from avs.report.collect import Cell, Episodes, read_dataset
from avs.report.collect_states import read_states
from avs.report.document import Document
from avs.report.formats.markdown import document_markdown
from avs.report.formats.writing import write_document
from avs.report.incomplete_coverage import incomplete_coverage
from avs.report.incomplete_explorations import incomplete_explorations
from avs.report.incomplete_scorers import incomplete_scorers
from avs.report.report_settings import BASE
from avs.report.tables.data_sets_side_by_side import ShownDataSet, side_by_side
from avs.report.tables.method_significance import method_significance
from avs.report.tables.representation_agreement import representation_agreement
from avs.report.tables.runtime_summary import runtime_summary
from avs.report.tables.scene_by_scene import scene_by_scene
from avs.report.tables.score_ranking import score_ranking
from avs.report.tables.selection_times import selection_times
from avs.report.tables.selection_times_numbers import read_runtimes
from avs.report.tables.setting_sensitivity import setting_sensitivity
from avs.report.tables.view_synthesis import view_synthesis
from avs.report.wanted_records import (
    UnfinishedRun,
    WantedAgnostic,
    WantedEpisode,
    WantedRecord,
    WantedSensitivity,
    WantedStates,
    WantedTable,
    WantedTimes,
)
from avs.scene.scene import SceneFile
from avs.system.errors import UserError
from avs.system.job_logs import why_missing
from avs.system.reasons import Reason
from avs.system.records import read_record

_NVS, _COVERAGE, _SLAM = "nvs_", "coverage_", "active_slam"  # begin the names of the tables that a run prints

_Value = TypeVar("_Value")
_Record = TypeVar("_Record", Episode, CommonStates, Runtime)


def write_incomplete_tables(run: UnfinishedRun, out: Path) -> tuple[list[str], list[str]]:
    """Write the tables of what is there to the folder ``out``, in place of what it held.

    A table names its gaps in caption and notes; one without any is as the complete run makes it.

    Returns:
        The tables of view synthesis, coverage and active SLAM as Markdown; and a line for each that cannot be made.
    """
    documents, lines = incomplete_documents(run)
    shutil.rmtree(out, ignore_errors=True)
    for name, document in documents.items():
        write_document(document, out / name)
    shown = [each for name, each in documents.items() if name.startswith((_NVS, _COVERAGE, _SLAM))]
    return [document_markdown(each) for each in shown], lines


def incomplete_documents(run: UnfinishedRun) -> tuple[dict[str, Document], list[str]]:
    """Return the tables of what is there by name of their files, and a line for each that cannot be made."""
    documents: dict[str, Document] = {}
    lines: list[str] = []
    collected: dict[str, Episodes] = {}
    for table in run.tables:
        with _left_out_into(lines):
            episodes = existing_episodes(table)
            beside = (table.published, run.absent, run.reference, table.left_out, table.pictures)
            documents[f"{_NVS}{table.dataset}"] = view_synthesis(episodes, table.methods, *beside)
            documents[f"scenes_{table.dataset}"] = scene_by_scene(
                episodes, table.methods, table.published_scenes, run.absent, table.left_out
            )
            documents[f"significance_{table.dataset}"] = method_significance(
                episodes, table.methods, run.absent, table.left_out
            )
            collected[table.dataset] = episodes
        if table.states:
            with _left_out_into(lines):
                documents[f"ranking_{table.dataset}"] = _ranking(table)
    if run.times is not None:
        with _left_out_into(lines):
            episodes = collected.get(run.times.dataset, Episodes(run.times.dataset, {}))
            documents |= _selection_times(run.times, episodes)
    if run.scorers is not None:
        with _left_out_into(lines):
            documents["scorer"] = incomplete_scorers(run.scorers)
    with _left_out_into(lines):
        if run.side_by_side and all(name in collected for name in run.side_by_side):
            documents["re10k_mfr"] = side_by_side(_shown(run, collected), "re10k_mfr")
    for each in run.sensitivity:
        with _left_out_into(lines):
            documents[f"sensitivity_{each.dataset}"] = _sensitivity(each, run.absent)
    for table_of in run.agnostic:
        with _left_out_into(lines):
            documents[f"agnostic_{table_of.dataset}"] = _agnostic(table_of)
    for wanted in run.coverage:
        with _left_out_into(lines):
            if wanted.dataset in collected:
                name = f"{_COVERAGE}{wanted.dataset}"
                documents[name] = incomplete_coverage(wanted, collected[wanted.dataset], run.absent, run.reference)
    if run.explorations is not None:
        with _left_out_into(lines):
            documents[_SLAM] = incomplete_explorations(run.explorations)
    return documents, lines


def _shown(run: UnfinishedRun, collected: Mapping[str, Episodes]) -> list[ShownDataSet]:
    """Return the data sets that one table has side by side."""
    tables = {table.dataset: table for table in run.tables}
    return [
        ShownDataSet(
            collected[table.dataset], table.methods, run.absent, table.published, table.pictures, table.left_out
        )
        for table in (tables[name] for name in run.side_by_side)
    ]


def existing_episodes(table: WantedTable) -> Episodes:
    """Read the episodes of a data set that are there, with the reason for each that is not.

    Raises:
        UserError: there is none, or they cannot be compared with one another.
    """
    episodes = _existing(table.episodes, table.dataset, table.methods)
    if not episodes.cells:
        reasons = dict.fromkeys(why for cells in episodes.missing.values() for why in cells.values())
        raise UserError(f"tables of {table.dataset}", "no episode yet", "; ".join(reasons))
    return episodes


def _existing(wanted_episodes: Sequence[WantedEpisode], dataset: str, methods: Sequence[str]) -> Episodes:
    """Read the episodes that are there, with the reason for each that is not; there may be none."""
    paths: list[Path] = []
    missing: dict[str, dict[Cell, str]] = {}
    for wanted in wanted_episodes:
        why = _why_not(wanted, Episode)
        if why is None:
            paths.append(wanted.path)
        else:
            missing.setdefault(wanted.method, {})[wanted.cell] = why
    return replace(read_dataset(paths, methods, dataset) if paths else Episodes(dataset, {}), missing=missing)


def _sensitivity(wanted: WantedSensitivity, absent: Mapping[str, Reason]) -> Document:
    found = {name: _existing(each, wanted.dataset, wanted.methods) for name, each in wanted.settings.items()}
    if not any(episodes.cells for episodes in found.values()):
        raise UserError(f"sensitivity of {wanted.dataset}", "no episode yet", "go on with the run")
    return setting_sensitivity(found.pop(BASE), found, wanted.methods, absent)


def _agnostic(wanted: WantedAgnostic) -> Document:
    found = {name: _existing(each, wanted.dataset, wanted.methods) for name, each in wanted.representations.items()}
    if not any(episodes.cells for episodes in found.values()):
        raise UserError(f"representations of {wanted.dataset}", "no episode yet", "go on with the run")
    return representation_agreement(found, wanted.methods, wanted.dataset, wanted.absent)


def _ranking(table: WantedTable) -> Document:
    reasons = {wanted.cell: _why_not(wanted, CommonStates) for wanted in table.states}
    missing = {cell: why for cell, why in reasons.items() if why is not None}
    paths = [wanted.path for wanted in table.states if wanted.cell not in missing]
    if not paths:
        raise UserError(f"ranking of {table.dataset}", "no record yet", "; ".join(dict.fromkeys(missing.values())))
    return score_ranking(replace(read_states(paths, table.dataset), missing=missing), table.methods, table.unscored)


def _why_not(wanted: WantedEpisode | WantedStates, kind: type[_Record]) -> str | None:
    """Return why a record is not there or does not count, or None if it does."""
    found = _read(wanted, kind)
    if isinstance(found, str):
        return found
    differing = [name for name, value in wanted.settings.items() if getattr(found, name) != value]
    return f"it was run with another {differing[0]}" if differing else None


def _selection_times(wanted: WantedTimes, episodes: Episodes) -> dict[str, Document]:
    found = {each.method: _read(each, Runtime) for each in wanted.records}
    untimed = {method: Reason(cause="not timed", remedy=why) for method, why in found.items() if isinstance(why, str)}
    paths = [each.path for each in wanted.records if each.method not in untimed]
    if not paths:
        reasons = dict.fromkeys(str(reason.remedy) for reason in untimed.values())
        raise UserError("table of selection times", "no method is timed yet", "; ".join(reasons))
    alone = Episodes(
        episodes.dataset,
        {method: _of_scene(cells, wanted.scene) for method, cells in episodes.cells.items()},
        {method: _of_scene(cells, wanted.scene) for method, cells in episodes.missing.items()},
    )
    absent = {**wanted.absent, **untimed}
    timed = read_runtimes(paths)
    gaps = len(untimed)
    documents = {"runtime": selection_times(timed, alone, wanted.methods, absent, wanted.published, untimed=gaps)}
    for summary, (methods, published) in wanted.summaries.items():
        documents[f"runtime_{summary}"] = runtime_summary(summary, timed, alone, methods, absent, published, gaps)
    return documents


def _of_scene(cells: Mapping[Cell, _Value], scene: str) -> dict[Cell, _Value]:
    return {cell: value for cell, value in cells.items() if cell[0] == scene}


def _read(wanted: WantedRecord | WantedStates, kind: type[_Record]) -> _Record | str:
    """Return a record, or why it is not there or does not count."""
    if not wanted.path.exists() or not wanted.scene.exists():
        return why_missing(wanted.logs)
    try:
        found, scene = read_record(wanted.path, kind), read_record(wanted.scene, SceneFile)
    except UserError as error:
        return str(error)
    if found.scene_hash != scene.content_hash:
        return "it was run on an earlier version of the scene"
    return wanted.stale or found


@contextlib.contextmanager
def _left_out_into(lines: list[str]) -> Iterator[None]:
    """Turn a fault that leaves a table out into a line."""
    try:
        yield
    except UserError as error:
        lines.append(f"left out: {error}")
