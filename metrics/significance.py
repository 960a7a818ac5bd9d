"""Which of many methods differ: tests of all pairs, average ranks, and how many scenes would tell two methods apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats
from scipy.special import nctdtr, stdtr, stdtrit

from metrics.statistics import Interval

FloatArray = npt.NDArray[np.float64]

MOST_SCENES = 1000
"""More scenes than this are not counted: nobody has them."""

_PERMUTATIONS = 10_000


@dataclass(frozen=True)
class AverageRanks:
    """What Friedman's and Nemenyi's tests say of methods that were run on the same blocks.

    Attributes:
        ranks: the mean over blocks of the rank of each method; 1 is best, methods that are equal share their ranks.
        p_value: of Friedman's statistic under permutation within blocks: how often ranks that know no method differ as
            much.
        critical: difference of two average ranks from which on Nemenyi's test calls two methods different; infinite
            for one block.
        blocks: their number.
    """

    ranks: tuple[float, ...]
    p_value: float
    critical: float
    blocks: int


def p_value(interval: Interval, confidence: float = 0.95) -> float:
    """Return how probable a difference at least as far from zero is where there is none, by the interval's Student's t.

    Args:
        interval: of a mean difference, symmetric around it.
        confidence: its probability content, in 0..1.
    """
    error = (interval.high - interval.difference) / float(stdtrit(interval.freedom, 0.5 + confidence / 2.0))
    if error <= 0.0:
        return 1.0 if interval.difference == 0.0 else 0.0
    return 2.0 * float(stdtr(interval.freedom, -abs(interval.difference) / error))


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p values corrected for their number, so that rarely any of those below a level is below it by chance.

    Holm's step-down procedure (Scandinavian Journal of Statistics 6, 1979): the probability of even one false finding
    stays below the level, whatever the dependence between the tests.

    Args:
        p_values: one for each test, in 0..1.
    """
    corrected, largest = [0.0] * len(p_values), 0.0
    for index, place in enumerate(sorted(range(len(p_values)), key=lambda place: p_values[place])):
        largest = max(largest, min(1.0, (len(p_values) - index) * p_values[place]))
        corrected[place] = largest
    return corrected


def average_ranks(
    values: npt.ArrayLike, *, higher_is_better: bool, confidence: float = 0.95, seed: int = 0
) -> AverageRanks:
    """Return average ranks, Friedman's test and Nemenyi's critical difference (Demsar, JMLR 7, 2006).

    Friedman's statistic is compared with that of ranks permuted within blocks, which holds for any number of blocks,
    rather than with its chi-squared limit, which needs more than ten. The critical difference is the usual one, of the
    studentised range with infinitely many degrees of freedom: with few blocks an approximation.

    Args:
        values: ``[blocks, methods]`` finite numbers, two methods or more.
        higher_is_better: whether the largest value of a block has rank 1.
        confidence: one minus the level of the critical difference, in 0..1.
        seed: of the permutations.

    Raises:
        ValueError: the array is not such a table.
    """
    table = np.asarray(values, dtype=np.float64)
    if table.ndim != 2 or table.shape[0] < 1 or table.shape[1] < 2 or not np.isfinite(table).all():
        raise ValueError(f"values of the shape {table.shape} must be finite numbers [blocks, methods]")
    blocks, methods = table.shape
    ranks = stats.rankdata(-table if higher_is_better else table, axis=1)
    found, rng = _spread_of_means(ranks), np.random.default_rng(seed)
    drawn = [_spread_of_means(rng.permuted(ranks, axis=1)) for _ in range(_PERMUTATIONS)]
    as_far = sum(each >= found * (1.0 - 1e-12) for each in drawn)
    quantile = float(stats.studentized_range.ppf(confidence, methods, np.inf)) / math.sqrt(2.0)
    critical = quantile * math.sqrt(methods * (methods + 1) / (6.0 * blocks)) if blocks > 1 else math.inf
    return AverageRanks(tuple(map(float, ranks.mean(axis=0))), (1 + as_far) / (1 + _PERMUTATIONS), critical, blocks)


def _spread_of_means(ranks: FloatArray) -> float:
    """Return the sum of squared deviations of the mean ranks, of which Friedman's statistic is a multiple."""
    means = ranks.mean(axis=0)
    return float(((means - means.mean()) ** 2).sum())


def scenes_needed(difference: float, deviation: float, *, level: float = 0.05, power: float = 0.8) -> int | None:
    """Return how many scenes a paired, two-sided t test needs to find a difference.

    Args:
        difference: true mean difference of two methods.
        deviation: standard deviation of the scenes' differences around it.
        level: probability of a finding where there is no difference, for this one comparison.
        power: probability of finding the difference.

    Returns:
        The smallest number of two or more with that power, or None if it is larger than ``MOST_SCENES``.
    """
    if deviation <= 0.0:
        return 2 if difference else None
    effect, low, high = abs(difference) / deviation, 1, 2
    # Doubling keeps away from numbers so large that the noncentral distribution is not computed.
    while not _power(high, effect, level) >= power:
        if high >= MOST_SCENES:
            return None
        low, high = high, min(2 * high, MOST_SCENES)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if _power(middle, effect, level) >= power else (middle, high)
    return high


def _power(scenes: int, effect: float, level: float) -> float:
    """Return the probability of a finding, by the noncentral t distribution; the far tail is left out."""
    far = float(stdtrit(scenes - 1, 1.0 - level / 2.0))
    return 1.0 - float(nctdtr(scenes - 1, effect * math.sqrt(scenes), far))


def deviation_limits(deviation: float, scenes: int, *, confidence: float = 0.95) -> tuple[float, float]:
    """Return the interval of a standard deviation that was estimated from the differences of so many scenes.

    By the chi-squared distribution, which supposes normal differences.

    Args:
        deviation: the estimate, with n - 1.
        scenes: two or more.
        confidence: probability content, in 0..1.
    """
    tail, freedom = (1.0 - confidence) / 2.0, scenes - 1
    low, high = (math.sqrt(freedom / float(stats.chi2.ppf(each, freedom))) for each in (1.0 - tail, tail))
    return deviation * low, deviation * high
