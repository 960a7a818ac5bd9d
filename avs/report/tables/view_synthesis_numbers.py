"""The numbers of the view synthesis table: one entry for each method and metric."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avs.report.collect import Episodes, end_of_curve, image_mean
from avs.report.intervals import OVER, Over, interval
from avs.report.tables.episode_gaps import missing_row
from avs.system.reasons import Reason
from metrics.definitions import METRICS
from metrics.statistics import Interval, summarise

COLUMNS = tuple(METRICS[identifier] for identifier in ("psnr", "ssim", "lpips"))
"""The metrics of the view synthesis table, as the paper has them."""


@dataclass(frozen=True)
class Compared:
    """The paired difference of a method to the reference method in one metric.

    Attributes:
        value: mean over scenes of the mean over seeds of the differences.
        seeds: the seeds that both methods have with every scene.
        intervals: of the difference, by what they are over; those that do not exist are left out.
    """

    value: float
    seeds: tuple[int, ...]
    intervals: Mapping[Over, Interval]


@dataclass(frozen=True)
class Entry:
    """One metric of one method.

    Attributes:
        mean: mean over seeds of the mean over scenes, or None with a reason in ``missing``.
        spread: standard deviation over seeds of the mean over scenes; None for fewer than three seeds.
        scenes: number of scenes in the mean.
        seeds: number of seeds in the mean.
        against: difference to the reference method; None for the reference itself and where a mean is missing.
        missing: why there is no mean, or None.
    """

    mean: float | None = None
    spread: float | None = None
    scenes: int = 0
    seeds: int = 0
    against: Compared | None = None
    missing: Reason | None = None


def summarise_episodes(
    episodes: Episodes, methods: Sequence[str], reference: str | None, absent: Mapping[str, Reason]
) -> dict[str, dict[str, Entry]]:
    """Compute every entry, by identifier of the method and of the metric.

    Args:
        episodes: the episodes of one data set.
        methods: identifiers of the rows; those without episodes have the reason.
        reference: identifier of the method that the others are compared with, or None.
        absent: why a method could not run, by identifier.
    """
    return {
        method: {
            metric.identifier: _entry(episodes, method, metric.identifier, reference, absent) for metric in COLUMNS
        }
        for method in methods
    }


def scene_value(episodes: Episodes, method: str, scene: str, seed: int, metric: str) -> float | None:
    """Return the mean over the test images at the end of one episode, or None where the record lacks the metric."""
    return image_mean(end_of_curve(episodes.cells[method][scene, seed]), metric)


def _entry(episodes: Episodes, method: str, metric: str, reference: str | None, absent: Mapping[str, Reason]) -> Entry:
    seeds = episodes.complete_seeds(method)
    reason = missing_row(episodes, method, absent) or _missing_value(episodes, method, metric, seeds)
    if reason is not None:
        return Entry(missing=reason)
    summary = summarise([_scene_values(episodes, method, seed, metric) for seed in seeds])
    against = None if reference in (None, method) else _against(episodes, method, reference, metric)
    return Entry(summary.mean, summary.spread, len(episodes.scenes), len(seeds), against)


def _missing_value(episodes: Episodes, method: str, metric: str, seeds: Sequence[int]) -> Reason | None:
    """Say why a metric has no mean over all scenes for these seeds, or return None."""
    for scene in episodes.scenes:
        for seed in seeds:
            if scene_value(episodes, method, scene, seed, metric) is None:
                return Reason(cause=episodes.cells[method][scene, seed].absent.get(metric, "not measured"))
    return None


def _against(episodes: Episodes, method: str, reference: str, metric: str) -> Compared | None:
    """Compare on the scenes and seeds that both have completely."""
    seeds = [seed for seed in episodes.complete_seeds(method) if seed in episodes.complete_seeds(reference)]
    if not seeds or _missing_value(episodes, reference, metric, seeds) is not None:
        return None
    pairs = [
        (_scene_values(episodes, method, seed, metric), _scene_values(episodes, reference, seed, metric))
        for seed in seeds
    ]
    differences = [[own[index] - other[index] for own, other in pairs] for index in range(len(episodes.scenes))]
    mean = sum(sum(scene) / len(scene) for scene in differences) / len(differences)
    found = {over: interval(differences, over) for over in OVER}
    return Compared(mean, tuple(seeds), {over: each for over, each in found.items() if each is not None})


def _scene_values(episodes: Episodes, method: str, seed: int, metric: str) -> list[float]:
    """Return one value for each scene; the caller has made sure that none is missing."""
    values = [scene_value(episodes, method, scene, seed, metric) for scene in episodes.scenes]
    return [value for value in values if value is not None]
