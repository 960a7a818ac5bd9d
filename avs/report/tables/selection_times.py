"""What the table of selection times says: the paper's two runtime tables in one."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from avs.nvs.timing_record import Runtime
from avs.report.collect import Episodes
from avs.report.published import read_published
from avs.report.tables.summary import PUBLISHED_PREFIX, Entry, Row, Table, missing_episodes, printed_as, scene_value
from avs.system.errors import UserError
from avs.system.reasons import Reason
from avs.system.records import read_record
from metrics.definitions import METRICS, Metric

COLUMNS = (
    METRICS["psnr"],
    Metric("render_seconds", "Render", None, 3, "s", "rendering of the candidates in one selection"),
    Metric("score_seconds", "Score", None, 3, "s", "all the rest of one selection"),
    Metric("selection_seconds", "Selection", False, 3, "s", "one selection"),
    Metric("view_seconds", "Per view", False, 3, "s", "one selection, divided by the views that it chooses"),
    Metric("chosen", "Views", None, 0, "", "views that one selection chooses"),
    Metric("candidates", "Candidates", None, 0, "", "candidates of one selection"),
    Metric("primitives", "Gaussians", None, 0, "", "Gaussians of the reconstruction"),
    Metric("peak_memory_gb", "Memory", False, 2, "GB", "peak memory, 10^9 bytes"),
)
"""What the table has of each method, in order."""

PUBLISHED_SCENE = "garden"
"""The scene of the paper's two tables."""

_PUBLISHED_NAMES = {"gpu_memory_gb": "peak_memory_gb"}

PUBLISHED_COLUMNS = (
    Metric("published_psnr", "paper: PSNR", None, 2, "dB", "the paper's PSNR"),
    Metric("published_selection_seconds", "paper: selection", None, 2, "s", "the paper's time of one selection"),
    Metric("published_peak_memory_gb", "paper: GPU memory", None, 1, "GB", "the paper's peak memory"),
)
"""The paper's values: ``PUBLISHED_PREFIX`` and the metric that they stand beside."""


@dataclass(frozen=True)
class RuntimeTable:
    """What the table says.

    Attributes:
        table: one entry per method and metric; times are medians over the timed selections.
        records: by method.
        published: the paper's value with its digits, by method and metric.
        ranges: shortest and longest of the timed selections, by method and metric.
    """

    table: Table
    records: dict[str, Runtime]
    published: dict[tuple[str, str], str]
    ranges: dict[tuple[str, str], tuple[float, float]]


def read_runtimes(paths: Sequence[Path]) -> dict[str, Runtime]:
    """Read the records at ``paths`` and return them by method.

    Raises:
        UserError: no path is given, a record cannot be read, repeats another, or was timed in another situation.
    """
    if not paths:
        raise UserError("runtime records", "none given", "pass at least one")
    found: dict[str, Runtime] = {}
    for path in paths:
        record = read_record(path, Runtime)
        if record.method in found:
            raise UserError(path, f"is a second record of {record.method}", "pass one record for each method")
        first = next(iter(found.values()), record)
        for name in ("scene_hash", "seed", "captured", "candidates", "iteration", "device", "machine"):
            if getattr(record, name) != getattr(first, name):
                fault = f"{name} is not that of {first.method}, so that their times cannot be compared"
                raise UserError(path, fault, "time all methods again on one machine")
        found[record.method] = record
    return found


def summarise_runtime(
    records: Mapping[str, Runtime],
    episodes: Episodes,
    methods: Sequence[str],
    absent: Mapping[str, Reason],
    published: Sequence[Path],
) -> RuntimeTable:
    """Compute every entry.

    Args:
        records: selection times by method.
        episodes: on the scene that they were measured on, for the PSNR.
        methods: identifiers of the rows, in order.
        absent: why a method is not timed, by identifier.
        published: files of ``results/published`` with the paper's times.

    Raises:
        UserError: the published values cannot be read.
    """
    printed: dict[tuple[str, str], str] = {}
    for path in published:
        for (method, name), value in read_published(path, PUBLISHED_SCENE).items():
            printed[method, _PUBLISHED_NAMES.get(name, name)] = value
    rows, ranges = [], {}
    for method in methods:
        record = records.get(method)
        entries = {"psnr": _psnr(episodes, method, absent)}
        for metric in COLUMNS[1:]:
            values = [] if record is None else values_of(record, metric.identifier)
            missing = None if values else absent.get(method, Reason(cause="not timed"))
            entries[metric.identifier] = Entry(
                statistics.median(values) if values else None, None, 1, 1, None, missing=missing
            )
            if len(values) > 1:
                ranges[method, metric.identifier] = (min(values), max(values))
        for metric in PUBLISHED_COLUMNS:
            paper = printed.get((method, metric.identifier.removeprefix(PUBLISHED_PREFIX)))
            entries[metric.identifier] = Entry(None if paper is None else float(paper), None, 1, 1, paper)
        rows.append(Row(method, *printed_as(episodes, method), entries))
    columns = [*COLUMNS, *(PUBLISHED_COLUMNS if printed else ())]
    return RuntimeTable(Table(episodes, columns, rows, None, has_published=False), dict(records), printed, ranges)


def values_of(record: Runtime, metric: str) -> list[float]:
    """Return the values of one of ``COLUMNS``: one for each timed selection, or a single one."""
    match metric:
        case "render_seconds" | "score_seconds":
            return [getattr(times, metric) for times in record.selections]
        case "selection_seconds":
            return [times.total_seconds for times in record.selections]
        case "view_seconds":
            return [times.total_seconds / record.chosen for times in record.selections]
        case "peak_memory_gb":
            return [record.peak_memory_bytes / 1e9]
        case _:
            return [float(getattr(record, metric))]


def _psnr(episodes: Episodes, method: str, absent: Mapping[str, Reason]) -> Entry:
    reason = missing_episodes(episodes, method, absent)
    if reason is not None:
        return Entry(None, None, 0, 0, None, missing=reason)
    seeds = episodes.complete_seeds(method)
    values = [scene_value(episodes, method, scene, seed, "psnr") for scene in episodes.scenes for seed in seeds]
    return Entry(statistics.fmean(value for value in values if value is not None), None, 1, len(seeds), None)
