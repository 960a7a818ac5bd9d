"""Writes the table of selection times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avs.nvs.timing_record import Runtime
from avs.report.collect import Episodes, read_episodes
from avs.report.formats import latex, markdown
from avs.report.formats.delimited import csv_text
from avs.report.formats.wording import oracle_note
from avs.report.tables.selection_times import COLUMNS, RuntimeTable, read_runtimes, summarise_runtime, values_of
from avs.report.tables.view_synthesis import with_ending
from avs.system.errors import UserError
from avs.system.files import write_text
from avs.system.reasons import Reason

FIELDS = ("method", "group", "metric", "value", "lowest", "highest", "repeats", "published", "note")
"""Columns of the csv file."""

# Beyond the printed digits: 10 microseconds, 10 kilobytes.
_EXTRA_DECIMALS = 2


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
        methods: identifiers of the methods, in the order of rows; each has its row, with the reason where it was not
            timed.
        absent: why a method is not timed, by identifier.
        published: files of ``results/published`` with the paper's times.
        out: path of the table without suffix.

    Raises:
        UserError: a record is missing, damaged, or not comparable with the others; or the published values cannot be
            read.
    """
    timed = read_runtimes(records)
    runtime = summarise_runtime(timed, _of_scene(episodes, methods, timed), methods, absent, published)
    sentences, notes = _caption(runtime), _notes(runtime)
    head = " ".join([*sentences, "Best in bold, second and third numbered."])
    scene = next(iter(timed.values())).scene
    write_text(with_ending(out, ".csv"), runtime_csv(runtime))
    write_text(with_ending(out, ".md"), markdown.document([head, markdown.grid(runtime.table)], notes))
    write_text(
        with_ending(out, ".tex"), latex.environment("runtime", scene, sentences, latex.grid(runtime.table), notes)
    )


def runtime_csv(runtime: RuntimeTable) -> str:
    """Return one row per method and column; an empty field is a missing value.

    ``value`` is the median over the timed selections, ``lowest`` and ``highest`` their range.
    """
    rows = []
    for row in runtime.table.rows:
        record = runtime.records.get(row.method)
        for metric in COLUMNS:
            entry = row.entries[metric.identifier]
            digits = metric.decimals + _EXTRA_DECIMALS if metric.decimals else 0
            numbers = [entry.mean, *runtime.ranges.get((row.method, metric.identifier), (None, None))]
            texts = ["" if number is None else f"{number:.{digits}f}" for number in numbers]
            repeats = 0 if record is None or metric.identifier == "psnr" else len(values_of(record, metric.identifier))
            paper = runtime.published.get((row.method, metric.identifier), "")
            rows.append(
                (
                    row.method,
                    row.group,
                    metric.identifier,
                    *texts,
                    repeats,
                    paper,
                    "" if entry.missing is None else str(entry.missing),
                )
            )
    return csv_text(FIELDS, rows)


def _of_scene(paths: Sequence[Path], methods: Sequence[str], timed: Mapping[str, Runtime]) -> Episodes:
    """Read the episodes and check that they are of the scene that was timed."""
    first = next(iter(timed.values()))
    collected = read_episodes(paths, methods)
    for episode in (each for episodes in collected for each in episodes.all):
        if episode.scene_hash != first.scene_hash:
            fault = f"is an episode on another scene than {first.scene}, on which selections were timed"
            raise UserError(f"{episode.scene}, {episode.method}", fault, "pass the episodes of the timed scene")
    return collected[0]


def _caption(runtime: RuntimeTable) -> list[str]:
    first = next(iter(runtime.records.values()))
    width, height = first.image_size
    where = first.machine.get("gpu") or f"{first.machine['processor']}, one process with {first.threads} thread(s)"
    repeats = max(len(record.selections) for record in runtime.records.values())
    return [
        f"Selection times on the scene {first.scene}: {first.captured} captured views, {first.candidates} candidates "
        f"of {width}x{height} pixels, after {first.iteration} iterations; {where}.",
        f"Median of up to {repeats} selections after a warm-up, nothing else running. PSNR: end of the episodes on "
        "this scene, mean over seeds.",
    ]


def _notes(runtime: RuntimeTable) -> list[str]:
    lines = []
    for row in runtime.table.rows:
        reasons = [row.entries[metric.identifier].missing for metric in COLUMNS]
        found = list(dict.fromkeys(reason for reason in reasons if reason is not None))
        lines += [f"{row.label}: {reason}" for reason in found]
    records = runtime.records.values()
    whole = [record.label for record in records if not any(times.render_seconds for times in record.selections)]
    if whole:
        lines.append(f"Score holds the whole selection of {', '.join(whole)}: no rendering is told apart")
    own = [record.label for record in records if record.own_fit]
    if own:
        lines.append(f"{', '.join(own)}: timed on a reconstruction fitted with the method's own loss")
    first = next(iter(records))
    if first.device == "cuda":
        lines.append("Memory: peak of the allocator on the GPU from the loading of the reconstruction on")
    else:
        lines.append("Memory: peak resident memory of a process that does nothing else, with all its libraries")
    if len(runtime.table.metrics) > len(COLUMNS):
        lines.append(
            "paper: on the scene Garden of Mip-NeRF360 with an NVIDIA 4090; with other images and another number of "
            "Gaussians on another machine, so that no difference to it is printed"
        )
    lines += [note for episode in runtime.table.episodes.all for note in episode.notes]
    return [*dict.fromkeys(lines), *oracle_note(runtime.table)]
