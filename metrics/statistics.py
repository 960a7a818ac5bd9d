"""Summaries over scenes and seeds: mean, spread, and a paired bootstrap interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Summary:
    """Mean and spread of a method's metric.

    Attributes:
        mean: mean over seeds of the mean over scenes.
        spread: standard deviation (n - 1) over seeds of the mean over scenes; None for one seed, where it is undefined.
    """

    mean: float
    spread: float | None


@dataclass(frozen=True)
class Interval:
    """A difference between two methods with its bootstrap interval.

    Attributes:
        difference: mean over scenes of the mean over seeds of the paired differences.
        low: lower end of the interval.
        high: upper end of the interval.
    """

    difference: float
    low: float
    high: float


def summarise(values: npt.ArrayLike) -> Summary:
    """Return mean and spread of ``[seeds, scenes]`` values, all of them present.

    Raises:
        ValueError: the array is not two-dimensional, is empty, or has values that are not finite.
    """
    table = np.asarray(values, dtype=np.float64)
    if table.ndim != 2 or table.size == 0 or not np.isfinite(table).all():
        raise ValueError(f"values of the shape {table.shape} must be finite numbers [seeds, scenes]")
    scene_means = table.mean(axis=1)
    spread = float(scene_means.std(ddof=1)) if len(scene_means) > 1 else None
    return Summary(float(scene_means.mean()), spread)


def paired_bootstrap(
    differences: Sequence[npt.ArrayLike], *, confidence: float = 0.95, resamples: int = 10_000, seed: int = 0
) -> Interval | None:
    """Return the percentile bootstrap interval of the mean difference between two methods.

    The bootstrap has two levels, as the data have: scenes are drawn with replacement, then, within each scene drawn,
    its seeds (Davison and Hinkley 1997, section 3.8). Pairing is the caller's: each difference is taken on one scene
    with one seed. With few scenes the interval is too narrow, as every bootstrap of few units is; with three scenes
    and one seed it spans the smallest to the largest difference.

    Args:
        differences: one sequence of differences, one per seed, for each scene.
        confidence: probability content of the interval, in 0..1.
        resamples: number of bootstrap samples.
        seed: seed of the resampling; equal arguments give equal bits.

    Returns:
        None if there is only one difference in all, where no interval exists.

    Raises:
        ValueError: a scene without differences, a value that is not finite, or no scene.
    """
    scenes = [np.atleast_1d(np.asarray(scene, dtype=np.float64)) for scene in differences]
    if not scenes or any(scene.ndim != 1 or scene.size == 0 or not np.isfinite(scene).all() for scene in scenes):
        raise ValueError("each scene needs a sequence of finite differences")
    if sum(len(scene) for scene in scenes) == 1:
        return None
    generator = np.random.default_rng(seed)
    drawn = generator.integers(len(scenes), size=(resamples, len(scenes)))
    means = np.empty((resamples, len(scenes)))
    for index, scene in enumerate(scenes):
        chosen = drawn == index
        seeds = generator.integers(len(scene), size=(int(chosen.sum()), len(scene)))
        means[chosen] = scene[seeds].mean(axis=1)
    tail = (1.0 - confidence) / 2.0
    low, high = np.quantile(means.mean(axis=1), [tail, 1.0 - tail])
    return Interval(float(np.mean([scene.mean() for scene in scenes])), float(low), float(high))
