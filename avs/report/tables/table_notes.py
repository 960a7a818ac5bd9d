"""Sentences that the captions and notes of several tables share."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from avs.report.collect import Episodes
from avs.report.methods import Presented
from avs.report.tables.episode_gaps import fewer_seeds, left_out
from avs.selection.contract import UNRANKED
from avs.system.reasons import Reason
from metrics.definitions import Metric
from metrics.statistics import ENOUGH_FOR_SPREAD


def scenes_and_seeds(episodes: Episodes) -> list[str]:
    """Return how many scenes and seeds there are, and which."""
    scenes, seeds = episodes.scenes, episodes.seeds
    return [
        f"{count(len(scenes), 'scene')} ({', '.join(scenes)})",
        f"{count(len(seeds), 'seed')} ({', '.join(map(str, seeds))})",
    ]


def whole_row(reasons: Iterable[Reason | None]) -> Reason | None:
    """Return the one reason for which all numbers of a row are missing, or None."""
    found = set(reasons)
    return next(iter(found)) if len(found) == 1 else None


def missing_notes(
    episodes: Episodes,
    metrics: Sequence[Metric],
    methods: Sequence[Presented],
    reasons: Mapping[str, Mapping[str, Reason | None]],
) -> list[str]:
    """Say why cells are empty: for a whole column once, for a whole row once, else cell by cell; and what is left out.

    Args:
        episodes: what the table is computed from.
        metrics: its columns.
        methods: its rows, in order.
        reasons: why a number is missing, by identifier of the method and of the metric.
    """
    ran = [reasons[method.identifier] for method in methods if method.identifier in episodes.cells]
    columns = {metric.identifier: whole_row(row[metric.identifier] for row in ran) for metric in metrics}
    lines = [f"{metric.name}: {columns[metric.identifier]}" for metric in metrics if columns[metric.identifier]]
    notes: dict[str, list[str]] = {}  # methods that share what is said of their whole row share the note
    for method in methods:
        row = reasons[method.identifier]
        whole = whole_row(row.values())
        said = fewer_seeds(episodes, method.identifier) if whole is None else str(whole)
        if whole is None:
            single = [metric for metric in metrics if row[metric.identifier] not in (None, columns[metric.identifier])]
            notes |= {f"{method.label}, {metric.name}: {row[metric.identifier]}": [] for metric in single}
        if said is not None:
            notes.setdefault(said, []).append(method.label)
    lines += [f"{', '.join(labels)}: {said}" if labels else said for said, labels in notes.items()]
    return [*left_out(episodes), *lines]


def no_scenes(left_out: Mapping[str, Reason]) -> list[str]:
    """Say why folders of a data set are none of its scenes, those of one reason together."""
    names: dict[str, list[str]] = {}
    for name, reason in left_out.items():
        names.setdefault(str(reason), []).append(name)
    return [f"left out, {', '.join(found)}: {reason}" for reason, found in names.items()]


def spread_note(episodes: Episodes, methods: Sequence[str]) -> list[str]:
    """Say why spreads over seeds are left out, if some are."""
    few = [len(episodes.complete_seeds(method)) for method in methods]
    if not any(0 < seeds < ENOUGH_FOR_SPREAD for seeds in few):
        return []
    told = f"no spread over seeds is printed of fewer than {ENOUGH_FOR_SPREAD} seeds"
    if len(episodes.seeds) >= ENOUGH_FOR_SPREAD:
        return [f"{told}; some rows have fewer that are complete"]
    return [f"{told}; here there {'is' if len(episodes.seeds) == 1 else 'are'} {len(episodes.seeds)}"]


def unranked_notes(methods: Sequence[Presented]) -> list[str]:
    """Return a line for each group of the table that does not compete: why."""
    groups = {method.group for method in methods}
    return [f"{group}: {why}" for group, why in UNRANKED.items() if group in groups]


def count(number: int, noun: str) -> str:
    """Return ``1 scene`` or ``2 scenes``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def span(values: Iterable[int]) -> str:
    """Return ``20``, or ``18 to 20``."""
    numbers = sorted(set(values))
    return str(numbers[0]) if len(numbers) == 1 else f"{numbers[0]} to {numbers[-1]}"


def spanned(values: Iterable[int], noun: str) -> str:
    """Return ``1 scene``, ``20 scenes``, or ``18 to 20 scenes``."""
    told = span(values)
    return f"{told} {noun}" if told == "1" else f"{told} {noun}s"
