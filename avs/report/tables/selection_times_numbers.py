"""The numbers of the table of selection times: medians of what was timed."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from avs.nvs.timing_record import Runtime
from avs.report.collect import Episodes
from avs.report.labels import told_apart
from avs.report.tables.episode_gaps import missing_row
from avs.report.tables.view_synthesis_numbers import scene_value
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


# What must agree, so that times can be compared.
_SHARED = ("scene_hash", "seed", "captured", "candidates", "iteration", "image_sizes", "device", "machine", "threads")

ELSEWHERE = Reason(
    cause="computed on the processor, not on the GPU",
    remedy="no time is printed beside those of a GPU; the record has it (docs/tables.md)",
)
"""Why a method has no time in a table of a GPU."""


@dataclass(frozen=True)
class Times:
    """One quantity of one method.

    Attributes:
        value: median over the timed selections, or None with a reason in ``missing``.
        values: of each timed selection, or a single one; empty for a quantity that comes from elsewhere.
        missing: why there is no value, or None.
    """

    value: float | None = None
    values: tuple[float, ...] = ()
    missing: Reason | None = None


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
        for name in _SHARED:
            if getattr(record, name) != getattr(first, name):
                fault = f"{name} is not that of {first.method}, so that their times cannot be compared"
                raise UserError(path, fault, "time all methods again on one machine")
        found[record.method] = record
    labels = told_apart({method: record.label for method, record in found.items()})
    return {method: record.model_copy(update={"label": labels[method]}) for method, record in found.items()}


def summarise_runtime(
    records: Mapping[str, Runtime], episodes: Episodes, methods: Sequence[str], absent: Mapping[str, Reason]
) -> dict[str, dict[str, Times]]:
    """Compute every quantity, by identifier of the method and of the column.

    Args:
        records: selection times by method.
        episodes: on the scene that they were measured on, for the PSNR.
        methods: identifiers of the rows.
        absent: why a method is not timed, by identifier.
    """
    numbers = {}
    for method in methods:
        record = records.get(method)
        row = {"psnr": _psnr(episodes, method, absent)}
        elsewhere = record is not None and record.computed_on != record.device
        for metric in COLUMNS[1:]:
            values = () if record is None or elsewhere else _values(record, metric.identifier)
            missing = None if values else ELSEWHERE if elsewhere else absent.get(method, Reason(cause="not timed"))
            row[metric.identifier] = Times(statistics.median(values) if values else None, values, missing)
        numbers[method] = row
    return numbers


def _values(record: Runtime, metric: str) -> tuple[float, ...]:
    """Return the values of one of ``COLUMNS``: one for each timed selection, or a single one."""
    match metric:
        case "render_seconds" | "score_seconds":
            return tuple(getattr(times, metric) for times in record.selections)
        case "selection_seconds":
            return tuple(times.total_seconds for times in record.selections)
        case "view_seconds":
            return tuple(times.total_seconds / record.chosen for times in record.selections)
        case "peak_memory_gb":
            return (record.peak_memory_bytes / 1e9,)
        case _:
            return (float(getattr(record, metric)),)


def _psnr(episodes: Episodes, method: str, absent: Mapping[str, Reason]) -> Times:
    reason = missing_row(episodes, method, absent)
    if reason is not None:
        return Times(missing=reason)
    seeds = episodes.complete_seeds(method)
    values = [scene_value(episodes, method, scene, seed, "psnr") for scene in episodes.scenes for seed in seeds]
    return Times(statistics.fmean(value for value in values if value is not None))
