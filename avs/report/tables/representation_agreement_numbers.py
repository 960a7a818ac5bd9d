"""The numbers of the table `agnostic`: each method's mean on each representation, and how far the orders agree."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.report.collect import Cell, Episodes
from avs.report.tables.setting_sensitivity_numbers import Standing
from avs.report.tables.view_synthesis_numbers import scene_value
from metrics.ranking import Correlation, kendall

METRICS = ("psnr", "ssim", "lpips")

DRAWS = 2000
"""Resamples of the bootstrap."""

FEWEST_SCENES = 3
"""Of fewer scenes no interval is told: a bootstrap of two has three outcomes."""

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class OrderAgreement:
    """How far two representations put the methods in one order, by mean PSNR.

    Attributes:
        first: name of a representation.
        second: name of another.
        tau: Kendall's tau-b of the means of the methods that compete and have both.
        interval: 2.5 % and 97.5 % of tau where scenes are drawn anew, and of each drawn scene its seeds, the same for
            all methods and both representations; None of too few scenes.
        chance: probability that two unrelated orders of so many methods agree at least as well; None where tau is.
        methods: number of methods compared.
    """

    first: str
    second: str
    tau: Correlation
    interval: tuple[float, float] | None
    chance: float | None
    methods: int


def metric_means(episodes: Episodes, method: str, grid: Sequence[Cell]) -> dict[str, float | None]:
    """Return the mean of each metric over all scenes and seeds of ``grid``; None where one is missing."""
    found: dict[str, float | None] = {}
    for metric in METRICS:
        there = episodes.cells.get(method, {})
        values = [scene_value(episodes, method, *cell, metric) if cell in there else None for cell in grid]
        known = [value for value in values if value is not None]
        found[metric] = float(np.mean(known)) if known and len(known) == len(values) else None
    return found


def order_agreements(
    episodes: Mapping[str, Episodes], standings: Mapping[str, Mapping[str, Standing]], grid: Sequence[Cell]
) -> list[OrderAgreement]:
    """Return how far the orders of every two representations agree, in the order of names.

    Args:
        episodes: of each representation, by its name.
        standings: of each method on each representation, by their names.
        grid: the scenes and seeds.
    """
    return [
        _agreement(first, second, episodes, standings, grid) for first, second in itertools.combinations(episodes, 2)
    ]


def _agreement(
    first: str,
    second: str,
    episodes: Mapping[str, Episodes],
    standings: Mapping[str, Mapping[str, Standing]],
    grid: Sequence[Cell],
) -> OrderAgreement:
    ranks = standings[first], standings[second]
    both = [method for method in ranks[0] if all(each[method].rank is not None for each in ranks)]
    one, other = (
        np.array(
            [[scene_value(episodes[name], method, *cell, "psnr") for cell in grid] for method in both], dtype=float
        )
        for name in (first, second)
    )
    if not both:
        return OrderAgreement(first, second, kendall([], []), None, None, 0)
    tau = kendall(one.mean(axis=1), other.mean(axis=1))
    if tau.value is None:
        return OrderAgreement(first, second, tau, None, None, len(both))
    chance = chance_of_agreement(len(both), tau.value)
    interval = bootstrap_interval(one, other, [scene for scene, _ in grid])
    return OrderAgreement(first, second, tau, interval, chance, len(both))


def bootstrap_interval(first: FloatArray, second: FloatArray, scenes: Sequence[str]) -> tuple[float, float] | None:
    """Return 2.5 % and 97.5 % of tau between the means of ``[methods, places]`` values, places being drawn anew.

    The seeds of one scene share what is the scene's own, so that a draw takes whole scenes first, and then seeds of
    each: places drawn one by one would give intervals that are too narrow.

    Args:
        first: values on one representation.
        second: those on another.
        scenes: the scene of each place.
    """
    names = list(dict.fromkeys(scenes))
    if len(names) < FEWEST_SCENES:
        return None
    generator = np.random.default_rng(0)
    places = [np.flatnonzero([scene == name for scene in scenes]) for name in names]
    drawn = generator.integers(len(names), size=(DRAWS, len(names)))
    seeds = max(map(len, places))
    rows = np.array([[generator.choice(places[scene], seeds) for scene in draw] for draw in drawn])
    rows = rows.reshape(DRAWS, -1)
    means = [values[:, rows].mean(axis=2) for values in (first, second)]  # [methods, draws]
    signs = [np.sign(values[:, None] - values[None]) for values in means]
    upper = np.triu_indices(len(first), 1)
    pairs = [each[upper] for each in signs]  # [pairs, draws]
    untied = np.sqrt((pairs[0] != 0).sum(axis=0) * (pairs[1] != 0).sum(axis=0))
    taus = (pairs[0] * pairs[1]).sum(axis=0) / np.maximum(untied, 1)
    low, high = np.quantile(taus, (0.025, 0.975))
    return float(low), float(high)


def chance_of_agreement(methods: int, tau: float) -> float:
    """Return the probability that Kendall's tau of two unrelated orders without ties is at least ``tau``.

    The number of orders with so many inversions follows from that of one method fewer: the last one goes before none,
    one, or up to all of the others.
    """
    counts = np.ones(1)
    for others in range(1, methods):
        counts = np.convolve(counts, np.ones(others + 1))
    pairs = methods * (methods - 1) / 2
    taus = 1 - 2 * np.arange(len(counts)) / pairs
    return float(counts[taus >= tau - 1e-9].sum() / counts.sum())
