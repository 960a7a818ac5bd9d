"""Summaries over scenes and seeds: mean, spread, and intervals of paired differences that hold for few of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

FloatArray = npt.NDArray[np.float64]

ENOUGH_FOR_SPREAD = 3
"""Of fewer values no spread is told: the standard deviation of two is off by more than a factor of two in 43 of 100."""


@dataclass(frozen=True)
class Summary:
    """Mean and spread of a method's metric.

    Attributes:
        mean: mean over seeds of the mean over scenes.
        spread: standard deviation (n - 1) over seeds of the mean over scenes; None for fewer seeds than
            ``ENOUGH_FOR_SPREAD``.
    """

    mean: float
    spread: float | None


@dataclass(frozen=True)
class Interval:
    """A mean difference between two methods with its confidence interval.

    Attributes:
        difference: mean over scenes of the mean over seeds of the paired differences.
        low: lower end of the interval.
        high: upper end of the interval.
        freedom: degrees of freedom of Student's t.
    """

    difference: float
    low: float
    high: float
    freedom: float


def summarise(values: npt.ArrayLike) -> Summary:
    """Return mean and spread of ``[seeds, scenes]`` values, all of them present.

    Raises:
        ValueError: the array is not two-dimensional, is empty, or has values that are not finite.
    """
    table = np.asarray(values, dtype=np.float64)
    if table.ndim != 2 or table.size == 0 or not np.isfinite(table).all():
        raise ValueError(f"values of the shape {table.shape} must be finite numbers [seeds, scenes]")
    return Summary(float(table.mean(axis=1).mean()), spread_of(table.mean(axis=1)))


def spread_of(values: npt.ArrayLike) -> float | None:
    """Return the standard deviation (n - 1) of ``[n]`` values, or None for fewer than ``ENOUGH_FOR_SPREAD``."""
    numbers = np.asarray(values, dtype=np.float64)
    return float(numbers.std(ddof=1)) if len(numbers) >= ENOUGH_FOR_SPREAD else None


def interval_over_scenes(differences: Sequence[npt.ArrayLike], *, confidence: float = 0.95) -> Interval | None:
    """Return the interval of the mean difference over scenes of this kind, with any seeds.

    Student's t of the scenes' mean differences. In the two-level model (scenes drawn at random, seeds drawn within
    each) their variance holds both levels, so that neither has to be estimated by itself, and for as many seeds in each
    scene the coverage is exact if differences are normal (Searle, Casella and McCulloch 1992, section 3.6).

    Args:
        differences: one sequence of differences, one per seed, for each scene. Pairing is the caller's: each difference
            is taken on one scene with one seed.
        confidence: probability content of the interval, in 0..1.

    Returns:
        None for one scene, which says nothing about others.

    Raises:
        ValueError: a scene without differences, a value that is not finite, or no scene.
    """
    means = np.array([scene.mean() for scene in _checked(differences)])
    if len(means) < 2:
        return None
    error = float(means.std(ddof=1)) / len(means) ** 0.5
    return _student(float(means.mean()), error, len(means) - 1, confidence)


def interval_over_seeds(differences: Sequence[npt.ArrayLike], *, confidence: float = 0.95) -> Interval | None:
    """Return the interval of the mean difference on these very scenes, over other seeds; other scenes are not covered.

    The scenes' variances over seeds need not be equal: the degrees of freedom are Satterthwaite's (Biometrics Bulletin
    2, 1946).

    Args:
        differences: as of ``interval_over_scenes``.
        confidence: probability content of the interval, in 0..1.

    Returns:
        None if a scene has one seed only.

    Raises:
        ValueError: a scene without differences, a value that is not finite, or no scene.
    """
    scenes = _checked(differences)
    if min(map(len, scenes)) < 2:
        return None
    mean = float(np.mean([scene.mean() for scene in scenes]))
    variances = np.array([scene.var(ddof=1) / len(scene) for scene in scenes])
    total, parts = variances.sum(), variances**2 / np.array([len(scene) - 1 for scene in scenes])
    freedom = float(total**2 / parts.sum()) if parts.sum() > 0.0 else float(sum(map(len, scenes)) - len(scenes))
    return _student(mean, float(total**0.5) / len(scenes), freedom, confidence)


def _student(mean: float, error: float, freedom: float, confidence: float) -> Interval:
    half = float(stdtrit(freedom, 0.5 + confidence / 2.0)) * error
    return Interval(mean, mean - half, mean + half, freedom)


def _checked(differences: Sequence[npt.ArrayLike]) -> list[FloatArray]:
    scenes = [np.atleast_1d(np.asarray(scene, dtype=np.float64)) for scene in differences]
    if not scenes or any(scene.ndim != 1 or scene.size == 0 or not np.isfinite(scene).all() for scene in scenes):
        raise ValueError("each scene needs a sequence of finite differences")
    return scenes
