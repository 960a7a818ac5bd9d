"""The table of selection times: the paper's two runtime tables in one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from avs.nvs.timing_record import Runtime
from avs.report.collect import Episodes, read_episodes
from avs.report.document import Cell, Column, Document, Listing
from avs.report.formats.numbers import EXTRA_DECIMALS, plain
from avs.report.formats.writing import write_document
from avs.report.methods import Presented, presented
from avs.report.published import read_published
from avs.report.tables.arrangement import arranged
from avs.report.tables.episode_gaps import missing_episodes
from avs.report.tables.episode_notes import repeated_notes
from avs.report.tables.selection_times_numbers import COLUMNS, Times, read_runtimes, summarise_runtime
from avs.report.tables.table_notes import count, unranked_notes, whole_row
from avs.system.errors import UserError
from avs.system.reasons import Reason
from metrics.definitions import Metric

FIELDS = ("method", "group", "metric", "value", "lowest", "highest", "repeats", "published", "note")
"""Columns of the csv file."""

_PUBLISHED_SCENE = "garden"  # of the paper's two tables

# The paper's values stand in columns of their own, without a difference, under the names that its files give them.
_PUBLISHED_COLUMNS = (
    Metric("psnr", "paper: PSNR", None, 2, "dB", "the paper's PSNR"),
    Metric("selection_seconds", "paper: selection", None, 2, "s", "the paper's time of one selection"),
    Metric("gpu_memory_gb", "paper: GPU memory", None, 1, "GB", "the paper's peak memory"),
)
_BESIDE = {"psnr": "psnr", "selection_seconds": "selection_seconds", "peak_memory_gb": "gpu_memory_gb"}

_DISTURBED = 0.1  # cores that others keep busy; an idle system needs some hundredths

_Numbers = Mapping[str, Mapping[str, Times]]
_Paper = Mapping[tuple[str, str], str]


def write_runtime_table(
    records: Sequence[Path],
    episodes: Sequence[Path],
    methods: Sequence[str],
    absent: Mapping[str, Reason],
    published: Sequence[Path],
    out: Path,
) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md`` and ``.tex``.

    Args:
        records: ``avs.nvs.timing_record.Runtime`` files, at most one for each method, all of one scene.
        episodes: ``episode.json`` files of that scene, for the PSNR.
        methods: see ``selection_times``.
        absent: see ``selection_times``.
        published: see ``selection_times``.
        out: path of the table without suffix.

    Raises:
        UserError: a record is missing, damaged, or not comparable with the others; or the published values cannot be
            read.
    """
    timed = read_runtimes(records)
    collected = _of_scene(episodes, methods, timed)
    write_document(selection_times(timed, collected, methods, absent, published), out)


def selection_times(
    records: Mapping[str, Runtime],
    episodes: Episodes,
    methods: Sequence[str],
    absent: Mapping[str, Reason],
    published: Sequence[Path],
    untimed: int = 0,
) -> Document:
    """Return the table of what one selection costs.

    Args:
        records: selection times by method, at least one.
        episodes: on the scene that they were measured on, for the PSNR.
        methods: identifiers of the methods, in the order of rows; each has its row, with the reason where it was not
            timed.
        absent: why a method is not timed, by identifier.
        published: files of ``results/published`` with the paper's times.
        untimed: number of methods whose times a run has asked for and does not have.

    Raises:
        UserError: the published values cannot be read.
    """
    paper = {key: text for path in published for key, text in read_published(path, _PUBLISHED_SCENE).values.items()}
    metrics = [*COLUMNS, *(_PUBLISHED_COLUMNS if paper else ())]
    numbers = summarise_runtime(records, episodes, methods, absent)
    rows = [presented(method, episodes) for method in methods]
    ordered = [records[method] for method in methods if method in records]
    columns = _columns(metrics, fought_over=any(map(_fought_over, ordered)))
    cells = {method: _cells(method, numbers[method], paper) for method in methods}
    return Document(
        label=f"runtime-{ordered[0].scene}",
        caption=(*_incomplete(episodes, untimed), *_caption(ordered)),
        columns=columns,
        groups=arranged(columns, rows, cells),
        notes=tuple(_notes(rows, numbers, ordered, episodes, has_paper=bool(paper))),
        listing=_listing(rows, numbers, paper),
    )


def _columns(metrics: Sequence[Metric], fought_over: bool) -> tuple[Column, ...]:
    """Return the columns; times are not ranked where another program may have had the core of one of them."""
    return tuple(
        Column(replace(metric, higher_is_better=None) if fought_over and metric.unit == "s" else metric)
        for metric in metrics
    )


def _fought_over(record: Runtime) -> bool:
    """Whether the machine had more work than cores while a method was timed."""
    return record.other_cores is not None and record.other_cores + record.threads > int(record.machine["cores"])


def _cells(method: str, row: Mapping[str, Times], paper: _Paper) -> list[Cell]:
    whole = whole_row(times.missing for times in row.values())
    cells = [
        Cell(times.value, cause=whole.cause if whole is not None and index == 0 else None)
        for index, times in enumerate(row.values())
    ]
    texts = [paper.get((method, metric.identifier)) for metric in _PUBLISHED_COLUMNS] if paper else []
    return cells + [Cell(None if text is None else float(text)) for text in texts]


def _listing(rows: Sequence[Presented], numbers: _Numbers, paper: _Paper) -> Listing:
    """Return one record for each method and column.

    ``value`` is the median over the timed selections, ``lowest`` and ``highest`` their range.
    """
    records: list[tuple[str | int, ...]] = []
    for row in rows:
        for metric in COLUMNS:
            times = numbers[row.identifier][metric.identifier]
            digits = metric.decimals + EXTRA_DECIMALS if metric.decimals else 0
            ends = (min(times.values), max(times.values)) if len(times.values) > 1 else (None, None)
            texts = (plain(number, digits) for number in (times.value, *ends))
            published = paper.get((row.identifier, _BESIDE.get(metric.identifier, "")), "")
            note = "" if times.missing is None else str(times.missing)
            records.append((row.identifier, row.group, metric.identifier, *texts, len(times.values), published, note))
    return Listing(FIELDS, tuple(records))


def _of_scene(paths: Sequence[Path], methods: Sequence[str], timed: Mapping[str, Runtime]) -> Episodes:
    """Read the episodes and check that they are of the scene that was timed."""
    first = next(iter(timed.values()))
    collected = read_episodes(paths, methods)
    for episode in (each for episodes in collected for each in episodes.all):
        if episode.scene_hash != first.scene_hash:
            fault = f"is an episode on another scene than {first.scene}, on which selections were timed"
            raise UserError(f"{episode.scene}, {episode.method}", fault, "pass the episodes of the timed scene")
    return collected[0]


def _incomplete(episodes: Episodes, untimed: int) -> list[str]:
    gaps = [f"{count(untimed, 'method')} not timed" if untimed else None, missing_episodes(episodes)]
    told = [gap for gap in gaps if gap is not None]
    return [f"Incomplete: {', '.join(told)}."] if told else []


def _caption(records: Sequence[Runtime]) -> list[str]:
    first = records[0]
    width, height = first.image_size
    where = first.machine.get("gpu") or f"{first.machine['processor']}, one process with {first.threads} thread(s)"
    repeats = max(len(record.selections) for record in records)
    return [
        f"Selection times on the scene {first.scene}: {first.captured} captured views, {first.candidates} candidates "
        f"of {width}x{height} pixels, after {first.iteration} iterations; {where}.",
        f"Median of up to {count(repeats, 'selection')} after a warm-up; {_meanwhile(records)}. PSNR: end of the "
        "episodes on this scene, mean over seeds.",
    ]


def _meanwhile(records: Sequence[Runtime]) -> str:
    """Return what else the machine did."""
    loads = [record.other_cores for record in records if record.other_cores is not None]
    if not loads:
        return "what else the machine did is not known"
    ends = dict.fromkeys(f"{end:.2f}" for end in (min(loads), max(loads)))
    unknown = "" if len(loads) == len(records) else " as far as that is known"
    return f"other programs kept {' to '.join(ends)} cores of the machine busy{unknown}"


def _load_notes(records: Sequence[Runtime]) -> list[str]:
    """Name the methods that others disturbed."""
    lines = []
    disturbed = [each for each in records if each.other_cores is not None and each.other_cores > _DISTURBED]
    if disturbed:
        told = ", ".join(f"{each.label} ({each.other_cores:.2f})" for each in disturbed)
        lines.append(f"times may be too long, because other programs kept cores busy meanwhile: {told}")
    if any(map(_fought_over, records)):
        lines.append("times have no marks, because there was more work than cores")
    if records[0].device == "cuda":
        lines.append("whether other programs used the GPU is not measured")
    return lines


def _notes(
    rows: Sequence[Presented], numbers: _Numbers, records: Sequence[Runtime], episodes: Episodes, has_paper: bool
) -> list[str]:
    lines = []
    for row in rows:
        reasons = dict.fromkeys(times.missing for times in numbers[row.identifier].values())
        lines += [f"{row.label}: {reason}" for reason in reasons if reason is not None]
    lines += _load_notes(records)
    timed = [record for record in records if record.computed_on == record.device]
    whole = [record.label for record in timed if not any(times.render_seconds for times in record.selections)]
    if whole:
        lines.append(f"Score holds the whole selection of {', '.join(whole)}: no rendering is told apart")
    own = [record.label for record in records if record.own_fit]
    if own:
        lines.append(f"{', '.join(own)}: timed on a reconstruction fitted with the method's own loss")
    if records[0].device == "cuda":
        lines.append("Memory: peak of the allocator on the GPU from the loading of the reconstruction on")
    else:
        fitted = f"; that of {', '.join(own)} holds the fit" if own else ""
        lines.append(f"Memory: peak resident memory of the process, with all its libraries and the scene{fitted}")
    if has_paper:
        lines.append(
            "paper: on the scene Garden of Mip-NeRF360 with an NVIDIA 4090; with other images and another number of "
            "Gaussians on another machine, so that no difference to it is printed"
        )
    lines += repeated_notes(episodes)
    return [*dict.fromkeys(lines), *unranked_notes(rows)]
