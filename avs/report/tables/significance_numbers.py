"""Which methods of a data set differ: paired differences of all pairs, average ranks, scenes that it would take."""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avs.report.collect import Cell, Episodes
from avs.report.intervals import CONFIDENCE, OVER, Over, interval
from avs.report.tables.view_synthesis_numbers import scene_value
from metrics.definitions import Metric
from metrics.significance import AverageRanks, average_ranks, deviation_limits, holm, p_value, scenes_needed
from metrics.statistics import Interval

LEVEL = 1.0 - CONFIDENCE
"""Probability of even one false finding among all pairs."""

Grid = Mapping[str, Mapping[Cell, float]]
"""One number for each scene and seed, by method; of a method all scenes with each of its seeds."""


@dataclass(frozen=True)
class Needed:
    """How many scenes a paired t test needs for a power of 0.8; None for more than can be had.

    Attributes:
        scenes: with the standard deviation as it was estimated.
        low: with the lower end of its 95 % interval.
        high: with the upper end.
    """

    scenes: int | None
    low: int | None
    high: int | None


@dataclass(frozen=True)
class Tested:
    """One test of one pair.

    Attributes:
        interval: of the difference, by itself.
        p_value: by itself.
        corrected: the same, corrected by Holm for the number of pairs.
    """

    interval: Interval
    p_value: float
    corrected: float

    @property
    def differs(self) -> bool:
        """Whether the pair differs, with all pairs looked at."""
        return self.corrected <= LEVEL


@dataclass(frozen=True)
class Pair:
    """The paired difference of two methods.

    Attributes:
        first: identifier.
        second: identifier of what is subtracted.
        difference: mean over scenes of the mean over seeds.
        scenes: their number.
        seeds: number of those that both have.
        deviation: standard deviation over scenes of the difference; None for one scene.
        tests: by what they generalise to; those that do not exist are left out.
        needed: scenes that it takes to find this difference, or None where that cannot be estimated.
    """

    first: str
    second: str
    difference: float
    scenes: int
    seeds: int
    deviation: float | None
    tests: Mapping[Over, Tested]
    needed: Needed | None


def grid_of(episodes: Episodes, methods: Sequence[str], metric: Metric) -> Grid:
    """Return the numbers of the methods that have a seed with every scene, in order, without those of other seeds.

    Args:
        episodes: of one data set.
        methods: identifiers.
        metric: of the test images.
    """
    found = {}
    for method in methods:
        cells = [(scene, seed) for scene in episodes.scenes for seed in episodes.complete_seeds(method)]
        values = {cell: scene_value(episodes, method, *cell, metric.identifier) for cell in cells}
        known = {cell: value for cell, value in values.items() if value is not None}
        if known and len(known) == len(values):
            found[method] = known
    return found


def pairs_of(grid: Grid) -> list[Pair]:
    """Return all pairs of methods that share a seed, tested together."""
    both = list(itertools.combinations(grid, 2))
    shared = {pair: _differences(grid[pair[0]], grid[pair[1]]) for pair in both}
    differences = {pair: each for pair, each in shared.items() if each}
    tests: dict[tuple[str, str], dict[Over, Tested]] = {pair: {} for pair in differences}
    for over in OVER:
        intervals = {pair: interval(each, over) for pair, each in differences.items()}
        known = {pair: each for pair, each in intervals.items() if each is not None}
        values = [p_value(each, CONFIDENCE) for each in known.values()]
        for (pair, each), value, corrected in zip(known.items(), values, holm(values), strict=True):
            tests[pair][over] = Tested(each, value, corrected)
    return [_pair(*pair, each, tests[pair]) for pair, each in differences.items()]


def ranks_of(grid: Grid, metric: Metric) -> AverageRanks | None:
    """Return the average ranks of the methods over scenes, seeds averaged; None for fewer than two methods."""
    if len(grid) < 2:
        return None
    scenes = sorted({scene for cells in grid.values() for scene, _ in cells})
    means = [[statistics.fmean(_of_scene(cells, scene).values()) for cells in grid.values()] for scene in scenes]
    return average_ranks(means, higher_is_better=bool(metric.higher_is_better), confidence=CONFIDENCE)


def usual_deviation(pairs: Sequence[Pair]) -> float | None:
    """Return the median over pairs of the standard deviation of their differences over scenes, or None."""
    known = [pair.deviation for pair in pairs if pair.deviation is not None]
    return statistics.median(known) if known else None


def needed_for(difference: float, deviation: float, scenes: int) -> Needed:
    """Return how many scenes it takes to find a difference.

    Args:
        difference: that is to be found.
        deviation: standard deviation of the scenes' differences.
        scenes: number of scenes that the deviation comes from.
    """
    low, high = deviation_limits(deviation, scenes, confidence=CONFIDENCE)
    return Needed(*(scenes_needed(difference, each, level=LEVEL) for each in (deviation, low, high)))


def _pair(first: str, second: str, differences: list[list[float]], tests: Mapping[Over, Tested]) -> Pair:
    means = [statistics.fmean(scene) for scene in differences]
    difference = statistics.fmean(means)
    deviation = statistics.stdev(means) if len(means) > 1 else None
    needed = None if deviation is None else needed_for(difference, deviation, len(means))
    return Pair(first, second, difference, len(means), len(differences[0]), deviation, tests, needed)


def _differences(one: Mapping[Cell, float], other: Mapping[Cell, float]) -> list[list[float]]:
    """Return the differences on the seeds that both have, by scene; nothing where they share none."""
    shared = sorted(one.keys() & other.keys())
    scenes = dict.fromkeys(scene for scene, _ in shared)
    return [[one[cell] - other[cell] for cell in shared if cell[0] == scene] for scene in scenes]


def _of_scene(cells: Mapping[Cell, float], scene: str) -> dict[Cell, float]:
    return {cell: value for cell, value in cells.items() if cell[0] == scene}
