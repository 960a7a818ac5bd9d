"""The numbers of a table of episodes: one entry for each method and metric, such as those of view synthesis."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from avs.report.collect import Episodes, end_of_curve, image_mean
from avs.report.intervals import OVER, Over, interval
from avs.report.tables.episode_gaps import missing_row
from avs.system.reasons import Reason
from metrics.definitions import METRICS, Metric
from metrics.statistics import Interval, summarise

COLUMNS = tuple(METRICS[identifier] for identifier in ("psnr", "ssim", "lpips"))
"""The metrics of the view synthesis table, as the paper has them."""


@dataclass(frozen=True)
class Quantities:
    """What a table has of each episode.

    Attributes:
        columns: its metrics.
        value: the number of a method, scene, seed and metric, or None where there is none.
        why_not: why there is none.
    """

    columns: tuple[Metric, ...]
    value: Callable[[Episodes, str, str, int, str], float | None]
    why_not: Callable[[Episodes, str, str, int, str], Reason]


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


def scene_value(episodes: Episodes, method: str, scene: str, seed: int, metric: str) -> float | None:
    """Return the mean over the test images at the end of one episode, or None where the record lacks the metric."""
    return image_mean(end_of_curve(episodes.cells[method][scene, seed]), metric)


def _not_measured(episodes: Episodes, method: str, scene: str, seed: int, metric: str) -> Reason:
    return Reason(cause=episodes.cells[method][scene, seed].absent.get(metric, "not measured"))


TEST_IMAGES = Quantities(COLUMNS, scene_value, _not_measured)
"""What the view synthesis table has."""


def summarise_episodes(
    episodes: Episodes,
    methods: Sequence[str],
    reference: str | None,
    absent: Mapping[str, Reason],
    quantities: Quantities = TEST_IMAGES,
) -> dict[str, dict[str, Entry]]:
    """Compute every entry, by identifier of the method and of the metric.

    Args:
        episodes: the episodes of one data set.
        methods: identifiers of the rows; those without episodes have the reason.
        reference: identifier of the method that the others are compared with, or None.
        absent: why a method could not run, by identifier.
        quantities: what the table has.
    """
    return {
        method: {
            metric.identifier: _entry(episodes, method, metric, reference, absent, quantities)
            for metric in quantities.columns
        }
        for method in methods
    }


def _entry(
    episodes: Episodes,
    method: str,
    metric: Metric,
    reference: str | None,
    absent: Mapping[str, Reason],
    quantities: Quantities,
) -> Entry:
    seeds = episodes.complete_seeds(method)
    name = metric.identifier
    reason = missing_row(episodes, method, absent) or _missing_value(episodes, method, name, seeds, quantities)
    if reason is not None:
        return Entry(missing=reason)
    summary = summarise([_scene_values(episodes, method, seed, name, quantities) for seed in seeds])
    compared = reference not in (None, method) and metric.higher_is_better is not None
    against = _against(episodes, method, str(reference), name, quantities) if compared else None
    return Entry(summary.mean, summary.spread, len(episodes.scenes), len(seeds), against)


def _missing_value(
    episodes: Episodes, method: str, metric: str, seeds: Sequence[int], quantities: Quantities
) -> Reason | None:
    """Say why a metric has no mean over all scenes for these seeds, or return None."""
    for scene in episodes.scenes:
        for seed in seeds:
            if quantities.value(episodes, method, scene, seed, metric) is None:
                return quantities.why_not(episodes, method, scene, seed, metric)
    return None


def _against(episodes: Episodes, method: str, reference: str, metric: str, quantities: Quantities) -> Compared | None:
    """Compare on the scenes and seeds that both have completely."""
    seeds = [seed for seed in episodes.complete_seeds(method) if seed in episodes.complete_seeds(reference)]
    if not seeds or _missing_value(episodes, reference, metric, seeds, quantities) is not None:
        return None
    own = [_scene_values(episodes, method, seed, metric, quantities) for seed in seeds]
    others = [_scene_values(episodes, reference, seed, metric, quantities) for seed in seeds]
    differences = [
        [one[index] - other[index] for one, other in zip(own, others, strict=True)]
        for index in range(len(episodes.scenes))
    ]
    mean = sum(sum(scene) / len(scene) for scene in differences) / len(differences)
    found = {over: interval(differences, over) for over in OVER}
    return Compared(mean, tuple(seeds), {over: each for over, each in found.items() if each is not None})


def _scene_values(episodes: Episodes, method: str, seed: int, metric: str, quantities: Quantities) -> list[float]:
    """Return one value for each scene; the caller has made sure that none is missing."""
    values = [quantities.value(episodes, method, scene, seed, metric) for scene in episodes.scenes]
    return [value for value in values if value is not None]
