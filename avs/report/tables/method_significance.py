"""The significance table of a data set: which methods differ, and how many scenes it would take to tell two apart."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from avs.report.collect import Episodes, read_dataset
from avs.report.document import Cell, Column, Document, Listing
from avs.report.formats.numbers import EXTRA_DECIMALS, plain
from avs.report.formats.writing import write_document
from avs.report.intervals import OVER, Over
from avs.report.methods import Presented, presented
from avs.report.tables.arrangement import arranged, in_groups
from avs.report.tables.episode_gaps import fewer_seeds, incomplete, missing_row
from avs.report.tables.episode_notes import episode_notes
from avs.report.tables.significance_numbers import Grid, Pair, grid_of, pairs_of, ranks_of, usual_deviation
from avs.report.tables.significance_words import (
    differing_pairs,
    power_notes,
    rank_notes,
    significance_caption,
    told_scenes,
)
from avs.report.tables.table_notes import no_scenes
from avs.report.tables.view_synthesis_numbers import COLUMNS
from avs.system.reasons import Reason
from metrics.definitions import METRICS, Metric
from metrics.significance import AverageRanks

FIELDS = ("metric", "method", "group", "mean", "average_rank", "over", "better_than", "worse_than", "compared", "note")
"""Columns of the csv file: how many methods a method is told to be better or worse than, by what the test is over."""

PAIR_FIELDS = (
    "metric",
    "first",
    "second",
    "difference",
    "deviation_over_scenes",
    "scenes",
    "seeds",
    "over",
    "low",
    "high",
    "p",
    "p_holm",
    "differs",
    "scenes_needed",
    "scenes_needed_low",
    "scenes_needed_high",
)
"""Columns of the csv file of pairs, one line for each test; the difference is of the first method to the second."""

RANK_FIELDS = ("metric", "methods", "scenes", "friedman_p", "critical_difference", "deviation_of_pairs")
"""Columns of the csv file of ranks."""

_PRINTED = METRICS["psnr"]
_DIGITS = 4  # of ranks in csv files

_COLUMNS = (
    Column(_PRINTED),
    Column(Metric("average_rank", "Average rank", False, 2, "", "mean over scenes of the rank")),
    *(
        Column(Metric(f"{name}_{over}", name, None, 0, "", "methods that a row is told from"), over=heading)
        for over, heading in (("scenes", "other scenes"), ("seeds", "these scenes, other seeds"))
        for name in ("above", "below")
    ),
    Column(Metric("to_best", "To the best", None, 2, "dB", "difference to the best mean")),
    Column(Metric("needed", "Scenes needed", None, 0, "", "to tell the row from the best mean")),
)


@dataclass(frozen=True)
class _Findings:
    """What is found of one metric.

    Attributes:
        metric: the metric.
        grid: the numbers of each method.
        whole: of the methods in the grid those that have every episode that another has: only they are ranked.
        pairs: the methods that share a seed, tested together.
        ranks: of the whole ones, in order; None for fewer than two.
    """

    metric: Metric
    grid: Grid
    whole: Sequence[str]
    pairs: list[Pair]
    ranks: AverageRanks | None

    def mean(self, method: str) -> float | None:
        return statistics.fmean(self.grid[method].values()) if method in self.grid else None

    def rank(self, method: str) -> float | None:
        known = dict(zip(self.whole, self.ranks.ranks, strict=True)) if self.ranks is not None else {}
        return known.get(method)

    @property
    def best(self) -> str | None:
        sign = 1.0 if self.metric.higher_is_better else -1.0
        return max(self.whole, key=lambda method: sign * (self.mean(method) or 0.0), default=None)


def write_significance_table(
    episodes: Sequence[Path],
    methods: Sequence[str],
    dataset: str,
    out: Path,
    absent: Mapping[str, Reason],
    left_out: Mapping[str, Reason] | None = None,
) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md`` and ``.tex``, ``_pairs.csv`` and ``_ranks.csv``.

    Equal records give equal bytes, whatever their order.

    Args:
        episodes: ``episode.json`` files of the data set.
        methods: see ``method_significance``.
        dataset: name of the data set.
        out: path of the table without suffix.
        absent: see ``method_significance``.
        left_out: see ``method_significance``.

    Raises:
        UserError: no episodes; or a record is missing, damaged, of another data set or not comparable with the others.
    """
    collected = read_dataset(episodes, methods, dataset)
    write_document(method_significance(collected, methods, absent, left_out), out)


def method_significance(
    episodes: Episodes,
    methods: Sequence[str],
    absent: Mapping[str, Reason],
    left_out: Mapping[str, Reason] | None = None,
) -> Document:
    """Return the table of the methods that compete; those without a rank are left out.

    Args:
        episodes: the episodes of one data set.
        methods: identifiers of the methods, in the order of rows.
        absent: why a method could not run, by identifier.
        left_out: why something that looks like a scene of the data set is none, by its name.
    """
    rows = [each for method in methods if (each := presented(method, episodes)).competes]
    ordered = [each.identifier for _, members in in_groups(rows) for each in members]
    found = [_findings(episodes, ordered, metric) for metric in COLUMNS]
    printed = found[0]
    labels = {row.identifier: row.label for row in rows}
    cells = {method: _cells(method, printed, missing_row(episodes, method, absent)) for method in ordered}
    return Document(
        label=f"significance-{episodes.dataset}",
        caption=(*incomplete(episodes), *significance_caption(episodes, _PRINTED, printed.pairs)),
        columns=_COLUMNS,
        groups=arranged(_COLUMNS, rows, cells),
        notes=(
            *(differing_pairs(printed.pairs, over, labels, _PRINTED) for over in OVER),
            *rank_notes(printed.ranks),
            *power_notes(printed.pairs, _PRINTED),
            *_gaps(episodes, rows, absent),
            *no_scenes(left_out or {}),
            *episode_notes(episodes),
        ),
        listing=_listing(found, rows, episodes, absent),
        appendices={"_pairs": _pair_listing(found), "_ranks": _rank_listing(found)},
    )


def _findings(episodes: Episodes, methods: Sequence[str], metric: Metric) -> _Findings:
    grid = grid_of(episodes, methods, metric)
    whole = [method for method in grid if presented(method, episodes).whole]
    ranks = ranks_of({method: grid[method] for method in whole}, metric)
    return _Findings(metric, grid, whole, pairs_of(grid), ranks)


def _cells(method: str, found: _Findings, reason: Reason | None) -> list[Cell]:
    mean, best = found.mean(method), found.best
    if mean is None or best is None:
        return [Cell(cause=None if reason is None else reason.cause), *(Cell() for _ in _COLUMNS[1:])]
    counts = [number for over in OVER for number in _counts(method, found, over)]
    pair = next((each for each in found.pairs if {each.first, each.second} == {method, best}), None)
    needed = None if pair is None or pair.needed is None else told_scenes(pair.needed)
    return [
        Cell(mean),
        Cell(found.rank(method)),
        *(Cell(None if number is None else float(number)) for number in counts),
        Cell(None if pair is None else pair.difference if pair.first == method else -pair.difference),
        Cell(text=needed),
    ]


def _counts(method: str, found: _Findings, over: Over) -> tuple[int | None, int | None]:
    """Return how many methods it is told to be better than, and worse than; None without such a test."""
    own = _tested(method, found, over)
    if not own:
        return None, None
    telling = [pair for pair in own if pair.tests[over].differs]
    higher = bool(found.metric.higher_is_better)
    wins = sum(((pair.difference > 0.0) == higher) == (pair.first == method) for pair in telling)
    return wins, len(telling) - wins


def _tested(method: str, found: _Findings, over: Over) -> list[Pair]:
    """Return the pairs with a method that one kind of test compares."""
    return [pair for pair in found.pairs if method in (pair.first, pair.second) and over in pair.tests]


def _gaps(episodes: Episodes, rows: Sequence[Presented], absent: Mapping[str, Reason]) -> list[str]:
    """Say why methods have no number, and which have fewer seeds."""
    told: dict[str, list[str]] = {}
    for row in rows:
        reason = missing_row(episodes, row.identifier, absent)
        said = fewer_seeds(episodes, row.identifier) if reason is None else str(reason)
        if said is not None:
            told.setdefault(said, []).append(row.label)
    return [f"{', '.join(labels)}: {said}" for said, labels in told.items()]


def _listing(
    found: Sequence[_Findings], rows: Sequence[Presented], episodes: Episodes, absent: Mapping[str, Reason]
) -> Listing:
    """Return one record for each metric, method and kind of test."""
    records: list[tuple[str | int, ...]] = []
    for each in found:
        digits = each.metric.decimals + EXTRA_DECIMALS
        for row in rows:
            reason = missing_row(episodes, row.identifier, absent)
            start = (each.metric.identifier, row.identifier, row.group, plain(each.mean(row.identifier), digits))
            note = str(reason) if reason is not None else "" if row.identifier in each.grid else "not measured"
            rank = plain(each.rank(row.identifier), _DIGITS)
            for over in OVER:
                counts = ["" if number is None else number for number in _counts(row.identifier, each, over)]
                records.append((*start, rank, over, *counts, len(_tested(row.identifier, each, over)), note))
    return Listing(FIELDS, tuple(records))


def _pair_listing(found: Sequence[_Findings]) -> Listing:
    """Return one record for each metric, pair and test; one without a test where there is none."""
    records: list[tuple[str | int, ...]] = []
    for each in found:
        digits = each.metric.decimals + EXTRA_DECIMALS
        for pair in each.pairs:
            numbers = (plain(pair.difference, digits), plain(pair.deviation, digits), pair.scenes, pair.seeds)
            start = (each.metric.identifier, pair.first, pair.second, *numbers)
            needed = (None,) * 3 if pair.needed is None else (pair.needed.scenes, pair.needed.low, pair.needed.high)
            end = tuple("" if number is None else number for number in needed)
            for over, test in pair.tests.items():
                ends = (plain(test.interval.low, digits), plain(test.interval.high, digits))
                values = (f"{test.p_value:.3g}", f"{test.corrected:.3g}", "yes" if test.differs else "no")
                records.append((*start, over, *ends, *values, *end))
            if not pair.tests:
                records.append((*start, "", "", "", "", "", "", *end))
    return Listing(PAIR_FIELDS, tuple(records))


def _rank_listing(found: Sequence[_Findings]) -> Listing:
    """Return one record for each metric: Friedman's and Nemenyi's tests, and how pairs deviate over scenes."""
    records: list[tuple[str | int, ...]] = []
    for each in found:
        if each.ranks is not None:
            tests = (
                (f"{each.ranks.p_value:.3g}", plain(each.ranks.critical, _DIGITS))
                if each.ranks.blocks > 1
                else ("", "")
            )
            deviation = plain(usual_deviation(each.pairs), each.metric.decimals + EXTRA_DECIMALS)
            records.append((each.metric.identifier, len(each.whole), each.ranks.blocks, *tests, deviation))
    return Listing(RANK_FIELDS, tuple(records))
