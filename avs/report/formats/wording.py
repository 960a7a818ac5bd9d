"""The words around a table: caption, notes, and numbers as text. Markdown and LaTeX print the same ones."""

from __future__ import annotations

from collections.abc import Iterable

from avs.report.collect import Episodes, own_settings
from avs.report.published import PRINTED_NAMES, STAND_INS
from avs.report.tables.summary import CONFIDENCE, PUBLISHED_PREFIX, Entry, Row, Table
from avs.selection.contract import ORACLE
from avs.system.reasons import Reason
from metrics.definitions import Metric

GROUPS = ("Geometric", "3D-based", "2D-based")
"""Order of the row groups; groups that a plug-in adds follow, oracles are the last."""

SHADES = 3
"""The best three values of a column are marked."""

# The range of n differences holds their median with probability 1 - 2^(1 - n), and no percentile bootstrap is wider
# than the range: with fewer than six scenes it cannot reach 95 %.
_ENOUGH_SCENES = 6

_RANGES = {"zero_one": "images in 0..1", "minus_one": "images in -1..1"}


def grouped(table: Table) -> list[tuple[str, list[Row]]]:
    """Return the rows by group: known groups in their order, others as they first occur, oracles; rows keep theirs."""
    others = (row.group for row in table.rows if row.group != ORACLE)
    names = list(dict.fromkeys([*GROUPS, *others, ORACLE]))
    groups = [(name, [row for row in table.rows if row.group == name]) for name in names]
    return [(name, rows) for name, rows in groups if rows]


def ranks(table: Table, metric: Metric) -> dict[str, int]:
    """Return 1, 2 or 3 for the methods with the best three printed values of a column, oracles left out.

    Values that print the same share a rank, and the next value has the next rank, as in the paper's Table 1. A quantity
    without a direction has no ranks.
    """
    if metric.higher_is_better is None:
        return {}
    entries = {row.method: row.entries[metric.identifier].mean for row in table.rows if row.group != ORACLE}
    printed = {method: float(f"{mean:.{metric.decimals}f}") for method, mean in entries.items() if mean is not None}
    best = sorted(set(printed.values()), reverse=metric.higher_is_better)[:SHADES]
    return {method: best.index(value) + 1 for method, value in printed.items() if value in best}


def measured(entry: Entry, metric: Metric, plus_minus: str) -> str | None:
    """Return the mean, with the spread where there is one, or None if the mean is missing."""
    if entry.mean is None:
        return None
    mean = f"{round(entry.mean, metric.decimals) + 0.0:.{metric.decimals}f}"  # what rounds to zero has no sign
    return mean if entry.spread is None else f"{mean}{plus_minus}{entry.spread:.{metric.decimals}f}"


def signed(value: float, metric: Metric) -> str:
    """Return a difference with its sign and an ASCII minus; what rounds to zero has no sign."""
    text = f"{value:+.{metric.decimals}f}"
    return text if float(text) else text[1:]


def against(entry: Entry, metric: Metric) -> str | None:
    """Return ``-0.31 [-0.80, +0.12]``, the difference to the reference method, or None if there is none."""
    if entry.against is None:
        return None
    difference, interval = entry.against
    if interval is None:
        return f"{signed(difference, metric)} [one pair]"
    return f"{signed(difference, metric)} [{signed(interval.low, metric)}, {signed(interval.high, metric)}]"


def has_spread(table: Table) -> bool:
    """Whether any entry has a spread."""
    return any(entry.spread is not None for row in table.rows for entry in row.entries.values())


def caption(table: Table) -> list[str]:
    """Return the sentences of the caption: what was measured, on what, and how."""
    episodes = table.episodes
    facts = [
        *scenes_and_seeds(episodes),
        f"{_range(len(episode.curve[-1].images) for episode in episodes.all)} test images a scene",
        f"{_range(episode.budget for episode in episodes.all)} views",
        f"{_range(len(episode.initial) for episode in episodes.all)} of them initial",
        f"{_range(episode.curve[-1].iteration for episode in episodes.all)} iterations",
    ]
    sentences = [
        f"Active view selection on the data set {episodes.dataset}: {', '.join(facts)}.",
        "Test images at the end of the optimisation; mean over seeds of the mean over scenes.",
    ]
    if has_spread(table):
        sentences.append("After the plus-minus sign: standard deviation over seeds of the mean over scenes.")
    return sentences


def scenes_and_seeds(episodes: Episodes) -> list[str]:
    """Return how many scenes and seeds there are, and which."""
    seeds = sorted({seed for cells in episodes.cells.values() for _, seed in cells})
    return [
        f"{_count(len(episodes.scenes), 'scene')} ({', '.join(episodes.scenes)})",
        f"{_count(len(seeds), 'seed')} ({', '.join(map(str, seeds))})",
    ]


def notes(table: Table) -> list[str]:
    """Return what a reader must know beside the numbers, each once."""
    lines = [*missing(table), *_spread(table), *_lpips(table.episodes), *_published(table), *_interval(table)]
    lines += oracle_note(table)
    lines += own_settings(table.episodes)
    lines += [note for episode in table.episodes.all for note in episode.notes]
    return list(dict.fromkeys(lines))


def comparison_title(table: Table) -> str | None:
    """Return the title of the second section, or None if there is no reference method."""
    if table.reference is None:
        return None
    return (
        f"Difference to {table.reference.label}, with {CONFIDENCE:.0%} paired bootstrap interval over scenes and seeds"
    )


def missing_cause(table: Table, row: Row, metric: Metric) -> str | None:
    """Return why the row is empty, without the command that helps, if it is and ``metric`` is the first."""
    reason = _missing_row(table, row) if metric is table.metrics[0] else None
    return None if reason is None else reason.cause


def _missing_row(table: Table, row: Row) -> Reason | None:
    """Return the reason for which all of a row is missing, except columns of published values, or None."""
    own = [metric for metric in table.metrics if not metric.identifier.startswith(PUBLISHED_PREFIX)]
    reasons = {row.entries[metric.identifier].missing for metric in own}
    return next(iter(reasons)) if len(reasons) == 1 else None


def missing(table: Table) -> list[str]:
    """Say why cells are empty: for a whole column once, for a whole row once, else cell by cell."""
    lines = []
    for metric in table.metrics:
        entries = [row.entries[metric.identifier] for row in table.rows if row.method in table.episodes.cells]
        reasons = {entry.missing for entry in entries}
        if len(reasons) == 1 and (reason := entries[0].missing) is not None:
            lines.append(f"{metric.name}: {reason}")
    for row in table.rows:
        if (whole := _missing_row(table, row)) is not None:
            lines.append(f"{row.label}: {whole}")
            continue
        for metric in table.metrics:
            single = row.entries[metric.identifier].missing
            if single is not None and f"{metric.name}: {single}" not in lines:
                lines.append(f"{row.label}, {metric.name}: {single}")
    return lines


def _spread(table: Table) -> list[str]:
    if any(entry.seeds == 1 for row in table.rows for entry in row.entries.values()):
        return ["with one seed the spread over seeds is undefined and left out"]
    return []


def oracle_note(table: Table) -> list[str]:
    """Return a line that tells what an oracle is, if the table has one."""
    if all(row.group != ORACLE for row in table.rows):
        return []
    return [f"{ORACLE}: chosen by looking at photographs that a method cannot see; upper references without a rank"]


def _interval(table: Table) -> list[str]:
    scenes = len(table.episodes.scenes)
    if table.reference is None or len(table.rows) == 1 or scenes >= _ENOUGH_SCENES:
        return []
    return [f"a bootstrap over {_count(scenes, 'scene')} gives intervals that are too narrow"]


def _lpips(episodes: Episodes) -> list[str]:
    settings = episodes.all[0].protocol.get("lpips")
    measured_anywhere = any("lpips" not in episode.absent for episode in episodes.all)
    if not isinstance(settings, dict) or not measured_anywhere:
        return []
    return [f"LPIPS: {settings.get('net')}, fed {_RANGES.get(str(settings.get('range')), 'unknown range')}"]


def _published(table: Table) -> list[str]:
    dataset = table.episodes.dataset
    if not table.has_published:
        return []
    if dataset in STAND_INS:
        source = PRINTED_NAMES[STAND_INS[dataset]]
        return [
            f"published: the paper's values on {source}; {dataset} stands in for its kind of capture with other scenes "
            "and a shorter schedule, so that the difference is no measure of a reproduction"
        ]
    return [f"published: the paper's values on {PRINTED_NAMES.get(dataset, dataset)}"]


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _range(values: Iterable[int]) -> str:
    numbers = sorted(set(values))
    return str(numbers[0]) if len(numbers) == 1 else f"{numbers[0]} to {numbers[-1]}"
