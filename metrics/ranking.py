"""Rank correlation: does a score order the candidates as the truth does?"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

FloatArray = npt.NDArray[np.float64]

FEWEST = 3
"""Candidates needed: the rank correlation of two is 1 or -1, whatever they are."""


@dataclass(frozen=True)
class Correlation:
    """A rank correlation, or why there is none.

    Attributes:
        value: in -1..1; None where it is undefined.
        reason: why it is undefined, or None.
    """

    value: float | None
    reason: str | None = None


def spearman(first: npt.ArrayLike, second: npt.ArrayLike) -> Correlation:
    """Return Spearman's rho: Pearson's correlation of the ranks, where ties have the mean of the ranks they share.

    Args:
        first: ``[n]`` finite numbers.
        second: ``[n]`` finite numbers, of the same candidates.

    Raises:
        ValueError: the shapes differ, or a number is not finite.
    """
    return _correlation(stats.spearmanr, first, second)


def kendall(first: npt.ArrayLike, second: npt.ArrayLike) -> Correlation:
    """Return Kendall's tau-b: concordant minus discordant pairs, over the geometric mean of the pairs without ties.

    Args:
        first: ``[n]`` finite numbers.
        second: ``[n]`` finite numbers, of the same candidates.

    Raises:
        ValueError: the shapes differ, or a number is not finite.
    """
    # The method concerns the significance, which is not used; the default computes it exactly, and slowly.
    return _correlation(functools.partial(stats.kendalltau, method="asymptotic"), first, second)


def mean_within(
    statistic: Callable[[npt.ArrayLike, npt.ArrayLike], Correlation],
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    groups: npt.ArrayLike,
) -> Correlation:
    """Return the mean over groups of the correlation within each, of the groups where it is defined.

    Args:
        statistic: ``spearman`` or ``kendall``.
        first: ``[n]`` finite numbers.
        second: ``[n]`` finite numbers.
        groups: ``[n]`` to which group each belongs.

    Raises:
        ValueError: the shapes differ, or a number is not finite.
    """
    (one, other), labels = _checked(first, second), np.asarray(groups)
    if labels.shape != one.shape:
        raise ValueError(f"{labels.shape} groups of {one.shape} numbers")
    each = [statistic(one[labels == label], other[labels == label]) for label in np.unique(labels)]
    defined = [correlation.value for correlation in each if correlation.value is not None]
    if defined:
        return Correlation(float(np.mean(defined)))
    return Correlation(None, each[0].reason if each else f"fewer than {FEWEST} candidates have both")


def _correlation(statistic: Callable[..., Any], first: npt.ArrayLike, second: npt.ArrayLike) -> Correlation:
    """Return the statistic of checked numbers, or why they have none."""
    pair = _checked(first, second)
    reason = _undefined(*pair)
    return Correlation(float(statistic(*pair).statistic)) if reason is None else Correlation(None, reason)


def _checked(first: npt.ArrayLike, second: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    one, other = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if one.ndim != 1 or one.shape != other.shape or not (np.isfinite(one).all() and np.isfinite(other).all()):
        raise ValueError(f"shapes {one.shape} and {other.shape}: both must be [n] finite numbers")
    return one, other


def _undefined(first: FloatArray, second: FloatArray) -> str | None:
    if len(first) < FEWEST:
        return f"fewer than {FEWEST} candidates have both"
    if np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        return "all values are equal"
    return None
