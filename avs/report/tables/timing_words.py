"""What the tables of selection times share: captions, notes, and which times are ranked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from avs.nvs.timing_record import Runtime
from avs.report.collect import Episodes, read_episodes
from avs.report.methods import Presented
from avs.report.tables.episode_gaps import fewer_seeds, missing_episodes
from avs.report.tables.episode_notes import episode_notes
from avs.report.tables.selection_times_numbers import Times
from avs.report.tables.table_notes import count, unranked_notes
from avs.system.errors import UserError
from metrics.definitions import Metric

_DISTURBED = 0.1  # cores that others keep busy; an idle system needs some hundredths

_Numbers = Mapping[str, Mapping[str, Times]]


def ranked_times(metrics: Sequence[Metric], records: Sequence[Runtime]) -> list[Metric]:
    """Return the metrics; times have no direction where they cannot be compared."""
    kept = comparable(records)
    return [replace(each, higher_is_better=None) if not kept and each.unit == "s" else each for each in metrics]


def comparable(records: Sequence[Runtime]) -> bool:
    """Whether times may be compared: none may have shared its core, and all were taken with the same packages."""
    return not any(map(_fought_over, records)) and not _differing_packages(records)


def _fought_over(record: Runtime) -> bool:
    """Whether the machine had more work than cores while a method was timed."""
    return record.other_cores is not None and record.other_cores + record.threads > int(record.machine["cores"])


def is_ranked(metric: str, method: str, episodes: Episodes) -> bool:
    """Return whether a value has a place among those of other methods: a time always, a PSNR with all its episodes."""
    return metric != "psnr" or not episodes.lacking(method)


def _differing_packages(records: Sequence[Runtime]) -> dict[str, dict[str, list[str]]]:
    """Return the packages whose versions differ between records, with the methods that each version timed."""
    names = dict.fromkeys(name for record in records for name in record.packages)
    found: dict[str, dict[str, list[str]]] = {name: {} for name in names}
    for record in records:
        for name in names:
            found[name].setdefault(record.packages.get(name, "none"), []).append(record.label)
    return {name: versions for name, versions in found.items() if len(versions) > 1}


def episodes_of_scene(paths: Sequence[Path], methods: Sequence[str], timed: Mapping[str, Runtime]) -> Episodes:
    """Read the episodes and check that they are of the scene that was timed."""
    first = next(iter(timed.values()))
    collected = read_episodes(paths, methods)
    for episode in (each for episodes in collected for each in episodes.all):
        if episode.scene_hash != first.scene_hash:
            fault = f"is an episode on another scene than {first.scene}, on which selections were timed"
            raise UserError(f"{episode.scene}, {episode.method}", fault, "pass the episodes of the timed scene")
    return collected[0]


def untimed_methods(episodes: Episodes, untimed: int) -> list[str]:
    """Return what begins the caption of an incomplete table: how many methods and episodes are missing."""
    gaps = [f"{count(untimed, 'method')} not timed" if untimed else None, missing_episodes(episodes)]
    told = [gap for gap in gaps if gap is not None]
    return [f"Incomplete: {', '.join(told)}."] if told else []


def timing_caption(records: Sequence[Runtime]) -> list[str]:
    """Return where and how times were measured."""
    first = records[0]
    ends = dict.fromkeys((first.image_sizes[0], first.image_sizes[-1]))
    sizes = " to ".join(f"{width}x{height}" for width, height in ends)
    where = first.machine.get("gpu") or f"{first.machine['processor']}, one process with {first.threads} thread(s)"
    repeats = max(len(record.selections) for record in records)
    return [
        f"Selection times on the scene {first.scene}: {first.captured} captured views, {first.candidates} candidates "
        f"of {sizes} pixels, after {first.iteration} iterations; {where}.",
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


def load_notes(records: Sequence[Runtime]) -> list[str]:
    """Name the methods that others disturbed, and those that were timed with other packages."""
    lines = []
    disturbed = [each for each in records if each.other_cores is not None and each.other_cores > _DISTURBED]
    if disturbed:
        told = ", ".join(f"{each.label} ({each.other_cores:.2f})" for each in disturbed)
        lines.append(f"times may be too long, because other programs kept cores busy meanwhile: {told}")
    if any(map(_fought_over, records)):
        lines.append("times have no marks, because there was more work than cores")
    for name, versions in _differing_packages(records).items():
        told = "; ".join(f"{version}: {', '.join(labels)}" for version, labels in versions.items())
        lines.append(f"times have no marks, because methods were timed with other versions of {name}: {told}")
    if records[0].device == "cuda":
        lines.append("whether other programs used the GPU is not measured")
    return lines


def timing_notes(
    rows: Sequence[Presented], numbers: _Numbers, records: Sequence[Runtime], episodes: Episodes, has_paper: bool
) -> list[str]:
    """Return what a reader must know of times and memory, and why some are not there."""
    lines = []
    for row in rows:
        reasons = dict.fromkeys(times.missing for times in numbers[row.identifier].values())
        lines += [f"{row.label}: {reason}" for reason in reasons if reason is not None]
        fewer = fewer_seeds(episodes, row.identifier)
        lines += [] if fewer is None else [f"{row.label}, PSNR: {fewer}"]
    lines += load_notes(records)
    timed = [record for record in records if record.computed_on == record.device]
    whole = [record.label for record in timed if not any(times.render_seconds for times in record.selections)]
    if whole and _has(numbers, "score_seconds"):
        lines.append(f"Score holds the whole selection of {', '.join(whole)}: no rendering is told apart")
    own = [record.label for record in records if record.own_fit]
    if own:
        lines.append(f"{', '.join(own)}: timed on a reconstruction fitted with the method's own loss")
    if _has(numbers, "peak_memory_gb"):
        lines.append(_memory_note(records[0].device, own))
    if has_paper:
        lines.append(
            "the paper's values: on the scene Garden of Mip-NeRF360 with an NVIDIA 4090; with other images and another "
            "number of Gaussians on another machine, so that no difference to it is printed"
        )
    lines += episode_notes(episodes)
    return [*dict.fromkeys(lines), *unranked_notes(rows)]


def _memory_note(device: str, own: Sequence[str]) -> str:
    """Return what memory is; ``own`` are the labels of methods with a fit of their own."""
    if device == "cuda":
        return "Memory: peak of the allocator on the GPU from the loading of the reconstruction on"
    fitted = f"; that of {', '.join(own)} holds the fit" if own else ""
    return f"Memory: peak resident memory of the process, with all its libraries and the scene{fitted}"


def _has(numbers: _Numbers, name: str) -> bool:
    """Return whether the table has a column."""
    return any(name in row for row in numbers.values())
