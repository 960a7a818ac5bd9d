"""The table of active SLAM, the paper's Table 4."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from avs.report.chosen_paths import is_proposed, method_of, published_as
from avs.report.collect_explorations import Explorations, Place, read_explorations
from avs.report.document import Cell, Column, Document, Group, Listing, Row
from avs.report.formats.numbers import EXTRA_DECIMALS, plain
from avs.report.formats.writing import write_document
from avs.report.published import read_published
from avs.report.tables.active_slam_curves import curves
from avs.report.tables.active_slam_notes import absences, gaps, remarks
from avs.report.tables.arrangement import ranks
from avs.slam.loop.exploration_record import ExplorationMeta, ExplorationRecord
from avs.slam.scoring.path_settings import PathScorerSettings
from avs.system.reasons import Reason
from metrics.definitions import Metric
from metrics.statistics import ENOUGH_FOR_SPREAD

FIELDS = ("building", "method", "metric", "value", "spread", "seeds", "published")
"""Columns of the csv file."""

RUN_FIELDS = ("building", "method", "seed", "metric", "value")
"""Columns of the csv file of explorations."""

Value = Callable[[ExplorationRecord, ExplorationMeta], float | None]

_COLUMNS: tuple[tuple[Metric, Value], ...] = (
    (
        Metric("scr_percent", "SCR", True, 2, "%", "visible surface within the threshold of a Gaussian's centre"),
        lambda record, meta: 100 * record.final.scr_means,
    ),
    (
        Metric(
            "scr_fused_percent", "SCR (depth)", True, 2, "%", "visible surface within the threshold of rendered depth"
        ),
        lambda record, meta: 100 * record.final.scr_fused,
    ),
    (
        Metric("seen_percent", "seen", True, 2, "%", "visible surface that the depth camera has seen"),
        lambda record, meta: 100 * record.final.seen,
    ),
    (
        Metric("scr_area_percent", "SCR area", True, 2, "%", "mean of SCR over the actions"),
        lambda record, meta: 100 * record.final.scr_area,
    ),
    (
        Metric("depth_mae_metres", "Depth MAE", False, 3, "m", "mean absolute error of rendered depth"),
        lambda record, meta: record.final.depth_mae,
    ),
    (
        Metric("psnr", "PSNR", True, 2, "dB", "of renderings at poses all over the floor"),
        lambda record, meta: record.final.psnr,
    ),
    (
        Metric("ssim", "SSIM", True, 3, "", "of renderings at poses all over the floor"),
        lambda record, meta: record.final.ssim,
    ),
    (Metric("path_metres", "path", None, 1, "m", "length of the way"), lambda record, meta: record.final.path_length),
    (
        Metric("decisions", "decisions", None, 0, "", "choices of a path"),
        lambda record, meta: float(len(record.decisions)),
    ),
    (
        Metric("decision_seconds", "per decision", None, 2, "s", "median time of one choice"),
        lambda record, meta: float(np.median(meta.decision_seconds)) if meta.decision_seconds else None,
    ),
)

_PAPER = ("scr_percent", "depth_mae_metres", "psnr")


def write_active_slam(
    records: Sequence[Path],
    buildings: Sequence[str],
    methods: Mapping[str, PathScorerSettings],
    published: Path,
    out: Path,
    absent: Mapping[str, Reason] = MappingProxyType({}),
    absent_buildings: Mapping[str, Reason] = MappingProxyType({}),
) -> None:
    """Write ``out`` with ``.csv``, ``.md`` and ``.tex``, ``_per_run.csv`` and ``_curves.csv``.

    Args:
        records: ``exploration.json`` files.
        buildings: names, in the order of groups.
        methods: what chooses the paths by identifier, in the order of rows; each has its row in each building.
        published: the paper's values.
        out: path of the table without suffix.
        absent: why a method could not explore, by identifier.
        absent_buildings: why a building is not explored, by name; its rows are without values.

    Raises:
        UserError: no record; one is missing, damaged or not comparable; or the published values cannot be read.
    """
    explorations = read_explorations(records)
    write_document(active_slam(explorations, buildings, methods, published, absent, absent_buildings), out)


def active_slam(
    explorations: Explorations,
    buildings: Sequence[str],
    methods: Mapping[str, PathScorerSettings],
    published: Path,
    absent: Mapping[str, Reason] = MappingProxyType({}),
    absent_buildings: Mapping[str, Reason] = MappingProxyType({}),
) -> Document:
    """Return the table: one group of rows for each building, the paper's values beside those that it has."""
    explorations = _with_gaps(explorations, buildings, methods)
    paper = read_published(published).values
    columns = tuple(
        Column(metric, "published, Gibson" if metric.identifier in _PAPER else None) for metric, _ in _COLUMNS
    )
    groups, listed = [], []
    for building in buildings:
        cells = {
            method: _cells(
                explorations,
                building,
                method,
                _values_of(paper, chooser),
                _cause(absent.get(method), building in absent_buildings),
            )
            for method, chooser in methods.items()
        }
        groups.append(Group(building, _rows(explorations, columns, building, methods, cells)))
        listed += _listed(explorations, building, methods, cells)
    return Document(
        label="active-slam",
        caption=_caption(explorations),
        columns=columns,
        groups=tuple(groups),
        notes=tuple(
            dict.fromkeys(
                [*gaps(explorations), *remarks(explorations, methods), *absences(absent_buildings), *absences(absent)]
            )
        ),
        listing=Listing(FIELDS, tuple(listed)),
        appendices={"_per_run": _per_run(explorations), "_curves": curves(explorations)},
    )


def _values_of(paper: Mapping[tuple[str, str], str], chooser: PathScorerSettings) -> dict[str, str]:
    """Return the paper's values of what chooses paths, by metric."""
    name = published_as(chooser)
    return {metric: value for (method, metric), value in paper.items() if method == name and metric in _PAPER}


def _with_gaps(explorations: Explorations, buildings: Sequence[str], methods: Iterable[str]) -> Explorations:
    """Return the explorations with those told as missing that a method lacks though others have that seed."""
    lacking: dict[Place, str] = {}
    for building in buildings:
        seeds = {place[2] for place in explorations.cells if place[0] == building}
        for method in methods:
            own = {record.seed for record in explorations.of(building, method)}
            lacking |= {(building, method, seed): "no record" for seed in sorted(seeds - own) if own}
    return replace(explorations, missing={**lacking, **explorations.missing})


def _cells(
    explorations: Explorations,
    building: str,
    method: str,
    paper: Mapping[str, str],
    missing: str,
) -> list[Cell]:
    """Return the mean over seeds, and their standard deviation where there are enough, of each column."""
    places = [place for place in sorted(explorations.cells) if place[:2] == (building, method)]
    cells: list[Cell] = []
    for metric, value in _COLUMNS:
        values = [value(explorations.cells[place], explorations.metas[place]) for place in places]
        numbers = [number for number in values if number is not None]
        beside = paper.get(metric.identifier)
        if not numbers:
            cells.append(Cell(published=beside, cause=missing if not places and not cells else None))
            continue
        enough = len(numbers) >= ENOUGH_FOR_SPREAD
        spread = float(np.std(numbers, ddof=1)) if enough and metric.higher_is_better is not None else None
        cells.append(Cell(float(np.mean(numbers)), spread, published=beside))
    return cells


def _rows(
    explorations: Explorations,
    columns: Sequence[Column],
    building: str,
    methods: Mapping[str, PathScorerSettings],
    cells: Mapping[str, list[Cell]],
) -> tuple[Row, ...]:
    """Return the rows of a building, with ranks among those that compete, have chosen, and have all their seeds."""
    gaps = {place[1] for place in explorations.missing if place[0] == building}
    able = [method for method in cells if explorations.ranked(method) and explorations.chose(building, method)]
    compete = [method for method in able if method not in gaps]
    marked = {method: list(row) for method, row in cells.items()}
    for index, column in enumerate(columns):
        values = {method: cells[method][index].value for method in compete}
        for method, rank in ranks(values, column.metric).items():
            marked[method][index] = replace(marked[method][index], rank=rank)
    return tuple(
        Row(
            explorations.label(method),
            tuple(marked[method]),
            is_proposed(chooser),
            method_of(chooser),
            method in compete,
        )
        for method, chooser in methods.items()
    )


def _caption(explorations: Explorations) -> tuple[str, ...]:
    record = next(iter(explorations.cells.values()))
    robot, seeds = record.settings, sorted({place[2] for place in explorations.cells})
    exploration, evaluation, camera = robot["exploration"], robot["evaluation"], robot["camera"]
    poses = "tracked poses" if robot["mapper"]["tracking"] else "given poses"
    lacking = len(explorations.missing)
    verb = "is" if lacking == 1 else "are"
    told = f"Incomplete: {lacking} of {lacking + len(explorations.cells)} explorations {verb} missing."
    sentences = [
        *([told] if lacking else []),
        f"Active SLAM: {exploration['steps']} actions of a robot with a camera of {camera['width']} x "
        f"{camera['height']} pixels, {poses}, {len(seeds)} seed{'s' if len(seeds) > 1 else ''}.",
        f"SCR: share of the surface that can be seen from the storey of the start within "
        f"{100 * evaluation['threshold']:g} cm of a Gaussian's centre, as the paper has it, and of the depth that the "
        "map renders along its way.",
        f"SCR area: mean of SCR over the actions, on straight lines between measurements every "
        f"{evaluation['every']} of them; fewer measurements give another number.",
        f"Depth MAE, PSNR and SSIM: at {record.final.poses} poses by chance all over the floor, what was not mapped "
        "included.",
    ]
    if len(seeds) >= ENOUGH_FOR_SPREAD:
        starts = {(place[0], record.start) for place, record in explorations.cells.items()}
        own = len(starts) == len({place[::2] for place in explorations.cells})
        told = "each with a start of its own" if own else "not all with a start of their own"
        sentences.append(f"After the plus-minus sign: standard deviation over seeds, {told}.")
    return tuple(sentences)


def _cause(reason: Reason | None, unread: bool) -> str:
    """Return what stands in place of the numbers of a method without explorations in a building."""
    if unread:
        return "building not read"
    return "no exploration" if reason is None else reason.cause


def _listed(
    explorations: Explorations, building: str, methods: Iterable[str], cells: Mapping[str, list[Cell]]
) -> list[tuple[str | int, ...]]:
    rows: list[tuple[str | int, ...]] = []
    for method in methods:
        seeds = len(explorations.of(building, method))
        for (metric, _), cell in zip(_COLUMNS, cells[method], strict=True):
            digits = metric.decimals + EXTRA_DECIMALS
            numbers = plain(cell.value, digits), plain(cell.spread, digits)
            rows.append((building, method, metric.identifier, *numbers, seeds, cell.published or ""))
    return rows


def _per_run(explorations: Explorations) -> Listing:
    rows: list[tuple[str | int, ...]] = []
    for place, record in sorted(explorations.cells.items()):
        for metric, value in _COLUMNS:
            number = plain(value(record, explorations.metas[place]), metric.decimals + EXTRA_DECIMALS)
            rows.append((*place, metric.identifier, number))
        for module, seconds in explorations.metas[place].seconds.items():
            rows.append((*place, f"{module}_seconds", plain(seconds, 2)))
    return Listing(RUN_FIELDS, tuple(rows))
