"""The numbers of the sensitivity table: each method's standing under each setting, and how far the orders agree."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avs.report.collect import Cell, Episodes
from avs.report.methods import Presented, presented
from avs.report.tables.view_synthesis_numbers import scene_value
from avs.system.reasons import Reason
from metrics.ranking import Correlation, kendall


@dataclass(frozen=True)
class Standing:
    """One method under one setting.

    Attributes:
        by_seed: for each seed, the mean over scenes of the test PSNR at the end, in dB; empty where it is missing.
        rank: 1 for the highest mean; None for a method that does not compete or has no mean.
        missing: why there is no mean, or None.
    """

    by_seed: tuple[float, ...] = ()
    rank: int | None = None
    missing: Reason | None = None

    @property
    def mean(self) -> float | None:
        """The mean over seeds."""
        return float(np.mean(self.by_seed)) if self.by_seed else None


@dataclass(frozen=True)
class Agreement:
    """The order of the methods under one setting.

    Attributes:
        with_base: Kendall's tau-b of the means with those under the run's own settings.
        between_seeds: the mean, over pairs of seeds, of the same between single seeds under this setting: what the
            noise of seeds leaves of an order.
        noise: standard deviation over seeds of the mean over scenes, in dB, pooled over methods; None for one seed.
        methods: number of methods that ``with_base`` compares.
    """

    with_base: Correlation
    between_seeds: Correlation
    noise: float | None
    methods: int


def standings(
    episodes: Episodes, methods: Sequence[Presented], grid: Sequence[Cell], absent: Mapping[str, Reason]
) -> dict[str, Standing]:
    """Return each method's standing under one setting, by identifier.

    A mean is over all scenes and seeds of ``grid``: one over those that happen to be there could not be compared with
    the same method's under other settings. A method that does not compete under this setting has no rank, as one that
    does not under the first.
    """
    found = {each.identifier: _standing(episodes, each.identifier, grid, absent) for each in methods}
    ranked = (each.identifier for each in methods if each.competes and presented(each.identifier, episodes).competes)
    means = {method: found[method].mean for method in ranked}
    known = [value for value in means.values() if value is not None]
    for method, mean in means.items():
        if mean is not None:
            rank = 1 + sum(value > mean for value in known)
            found[method] = Standing(found[method].by_seed, rank)
    return found


def agreement(base: Mapping[str, Standing], varied: Mapping[str, Standing]) -> Agreement:
    """Compare the order of the ranked methods under a setting with that under the run's own."""
    both = [method for method in base if base[method].rank is not None and varied[method].rank is not None]
    first = [float(np.mean(base[method].by_seed)) for method in both]
    second = [float(np.mean(varied[method].by_seed)) for method in both]
    table = np.array([varied[method].by_seed for method in varied if varied[method].rank is not None])
    return Agreement(kendall(first, second), _between_seeds(table), _pooled(table), len(both))


def _standing(episodes: Episodes, method: str, grid: Sequence[Cell], absent: Mapping[str, Reason]) -> Standing:
    if method in absent:
        return Standing(missing=absent[method])
    cells, reasons = episodes.cells.get(method, {}), episodes.missing.get(method, {})
    lacking: dict[str, list[str]] = {}
    for scene, seed in grid:
        if (scene, seed) not in cells:
            lacking.setdefault(reasons.get((scene, seed), "no episode"), []).append(f"{scene} with seed {seed}")
    if lacking:
        told = "; ".join(f"{', '.join(places)}: {why}" for why, places in lacking.items())
        return Standing(missing=Reason(cause="no episode" if not cells else "episodes missing", remedy=told))
    seeds = dict.fromkeys(seed for _, seed in grid)
    values = [[scene_value(episodes, method, *cell, "psnr") for cell in grid if cell[1] == seed] for seed in seeds]
    if any(value is None for row in values for value in row):
        return Standing(missing=Reason(cause="a record lacks the PSNR"))
    return Standing(tuple(float(np.mean(np.array(row, dtype=np.float64))) for row in values))


def _between_seeds(table: np.ndarray) -> Correlation:
    """Return the mean of Kendall's tau over pairs of the seeds of ``[methods, seeds]`` values."""
    seeds = table.shape[1] if table.ndim == 2 else 0
    if seeds < 2:
        return Correlation(None, "one seed")
    pairs = [kendall(table[:, one], table[:, other]) for one, other in itertools.combinations(range(seeds), 2)]
    values = [each.value for each in pairs]
    if any(value is None for value in values):
        return next(each for each in pairs if each.value is None)
    return Correlation(float(np.mean([value for value in values if value is not None])))


def _pooled(table: np.ndarray) -> float | None:
    """Return the root of the mean, over methods, of the variance (n - 1) over seeds."""
    if table.ndim != 2 or table.shape[1] < 2:
        return None
    return float(np.sqrt(np.mean(table.var(axis=1, ddof=1))))
