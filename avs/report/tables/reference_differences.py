"""The differences of all methods to one: the second section of a table of episodes, and its csv file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avs.report.collect import Episodes
from avs.report.document import Comparison, Difference, Listing
from avs.report.formats.numbers import EXTRA_DECIMALS, plain
from avs.report.intervals import CONFIDENCE, OVER, covers, printed_over
from avs.report.methods import Presented, presented
from avs.report.tables.arrangement import in_groups
from avs.report.tables.view_synthesis_numbers import COLUMNS, Entry
from metrics.definitions import Metric

FIELDS = ("method", "metric", "reference", "difference", "scenes", "seeds", "over", "low", "high", "freedom")
"""Columns of the csv file of differences to the reference method: one line for each interval that exists."""

Numbers = Mapping[str, Mapping[str, Entry]]
"""What ``view_synthesis_numbers.summarise_episodes`` returns."""


def comparison(reference: str, episodes: Episodes, rows: Sequence[Presented], numbers: Numbers) -> Comparison | None:
    """Return the differences to the reference method with one kind of interval, the same for all rows.

    Methods without a difference are left out; None if that leaves none.
    """
    over = printed_over(len(episodes.scenes), len(episodes.seeds))
    ordered = [row for _, members in in_groups(rows) for row in members]
    others = [row for row in ordered if any(entry.against is not None for entry in numbers[row.identifier].values())]
    if not others:
        return None

    def printed(entry: Entry) -> Difference | None:
        if entry.against is None:
            return None
        found = None if over is None else entry.against.intervals.get(over)
        return Difference(entry.against.value, None if found is None else (found.low, found.high))

    label = presented(reference, episodes).label
    return Comparison(
        title=f"Difference to {label}, paired, before rounding; {covers(over, len(episodes.scenes))}",
        rows=tuple((row.label, tuple(map(printed, numbers[row.identifier].values()))) for row in others),
    )


def listed_differences(
    episodes: Episodes,
    methods: Sequence[str],
    reference: str | None,
    numbers: Numbers,
    columns: Sequence[Metric] = COLUMNS,
) -> Listing:
    """Return one record for each method, metric and interval; one without an interval where there is none."""
    records: list[tuple[str | int, ...]] = []
    for method in methods:
        for metric in columns:
            against = numbers[method][metric.identifier].against
            if reference is None or against is None:
                continue
            digits = metric.decimals + EXTRA_DECIMALS
            start = (method, metric.identifier, reference, plain(against.value, digits))
            counts = (len(episodes.scenes), len(against.seeds))
            found = [(over, against.intervals[over]) for over in OVER if over in against.intervals]
            records += [
                (*start, *counts, over, plain(each.low, digits), plain(each.high, digits), plain(each.freedom, 2))
                for over, each in found
            ]
            if not found:
                records.append((*start, *counts, "", "", "", ""))
    return Listing(FIELDS, tuple(records))


def comparison_notes(
    compared: Comparison | None, reference: str | None, rows: Sequence[Presented], episodes: Episodes
) -> list[str]:
    """Say that intervals are not corrected for their number; or why there is no comparison where one is asked for."""
    if compared is not None:
        if all(each is None or each.interval is None for _, row in compared.rows for each in row):
            return []
        share = round(1.0 / (1.0 - CONFIDENCE))
        return [
            f"each interval is by itself: of {share} methods equal to the reference, one would exclude zero by chance"
        ]
    asked = [row.label for row in rows if row.identifier == reference]
    if not asked or len(rows) == 1 or episodes.complete_seeds(reference or ""):
        return []
    return [f"no difference to {asked[0]} is printed, because it has no seed with an episode of every scene"]


def fewer_compared(rows: Sequence[Presented], numbers: Numbers, reference: str | None, episodes: Episodes) -> list[str]:
    """Tell which methods are compared with the reference on fewer seeds than their mean is over."""
    if reference is None:
        return []
    label, lines = presented(reference, episodes).label, []
    for row in rows:
        entry = next(iter(numbers[row.identifier].values()))
        if entry.against is not None and len(entry.against.seeds) < max(entry.seeds, len(episodes.seeds)):
            seeds = ", ".join(map(str, entry.against.seeds))
            lines.append(f"{row.label}: compared with {label} on the seeds that both have, {seeds}")
    return lines
