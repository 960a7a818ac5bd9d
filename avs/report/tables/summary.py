"""What a table says, before it takes a form: one entry for each method and metric."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avs.report.collect import Episodes, end_of_curve, image_mean
from avs.selection import registry
from avs.system.reasons import Reason
from metrics.definitions import METRICS, Metric
from metrics.statistics import Interval, paired_bootstrap, summarise

CONFIDENCE = 0.95
"""Probability content of the bootstrap intervals."""

PUBLISHED_PREFIX = "published_"
"""Begins the identifiers of columns of published values that stand apart from the metric itself."""

COLUMNS = ("psnr", "ssim", "lpips")
"""The metrics of the view synthesis table, as the paper has them."""


@dataclass(frozen=True)
class Entry:
    """One metric of one method.

    Attributes:
        mean: mean over seeds of the mean over scenes, or None with a reason in ``missing``.
        spread: standard deviation over seeds of the mean over scenes; None for one seed.
        scenes: number of scenes in the mean.
        seeds: number of seeds in the mean.
        published: the paper's value with its digits, or None.
        against: difference to the reference method with its bootstrap interval. The interval is None if there is
            only one pair. ``against`` is None for the reference itself and where a mean is missing.
        missing: why there is no mean, or None.
    """

    mean: float | None
    spread: float | None
    scenes: int
    seeds: int
    published: str | None
    against: tuple[float, Interval | None] | None = None
    missing: Reason | None = None

    @property
    def difference(self) -> float | None:
        """The mean minus the published value, or None where one of them is missing."""
        return None if self.mean is None or self.published is None else self.mean - float(self.published)


@dataclass(frozen=True)
class Row:
    """One method: its identifier, printed name, row group, and one entry for each metric by identifier."""

    method: str
    label: str
    group: str
    entries: dict[str, Entry]


@dataclass(frozen=True)
class Table:
    """The view synthesis table of one data set.

    Attributes:
        episodes: what it is computed from.
        metrics: its metrics, in order.
        rows: its methods, in order.
        reference: the row that all others are compared with by bootstrap, or None if it has no episodes.
        has_published: whether there are published values to print.
    """

    episodes: Episodes
    metrics: list[Metric]
    rows: list[Row]
    reference: Row | None
    has_published: bool


def summarise_table(
    episodes: Episodes,
    methods: Sequence[str],
    published: Mapping[tuple[str, str], str] | None,
    reference: str,
    absent: Mapping[str, Reason],
) -> Table:
    """Compute every entry.

    Args:
        episodes: the episodes of one data set.
        methods: identifiers of the rows, in order; those without episodes keep their row, with the reason.
        published: the paper's values by (method, metric), or None.
        reference: identifier of the method that the others are compared with.
        absent: why a method could not run, by identifier.
    """
    metrics = [METRICS[identifier] for identifier in COLUMNS]
    rows = []
    for method in methods:
        label, group = printed_as(episodes, method)
        entries = {
            metric.identifier: _entry(episodes, method, metric.identifier, published or {}, reference, absent)
            for metric in metrics
        }
        rows.append(Row(method, label, group, entries))
    reference_row = next((row for row in rows if row.method == reference and row.method in episodes.cells), None)
    return Table(episodes, metrics, rows, reference_row, has_published=published is not None)


def scene_value(episodes: Episodes, method: str, scene: str, seed: int, metric: str) -> float | None:
    """Return the mean over the test images at the end of one episode, or None where the record lacks the metric."""
    return image_mean(end_of_curve(episodes.cells[method][scene, seed]), metric)


def missing_episodes(episodes: Episodes, method: str, absent: Mapping[str, Reason]) -> Reason | None:
    """Say why a method has no seed with an episode of every scene, or return None if it has one.

    Args:
        episodes: the episodes of one data set.
        method: identifier.
        absent: why a method could not run, by identifier.
    """
    cells = episodes.cells.get(method)
    if not cells:
        return absent.get(method, Reason(cause="no episode"))
    if episodes.complete_seeds(method):
        return None
    lacking = [scene for scene in episodes.scenes if scene not in {each for each, _ in cells}]
    return Reason(cause=f"no episode of {', '.join(lacking)}" if lacking else "no seed has an episode of every scene")


def printed_as(episodes: Episodes, method: str) -> tuple[str, str]:
    """Return printed name and group: from the records or, without any, from the method's metadata."""
    if cells := episodes.cells.get(method):
        episode = next(iter(cells.values()))
        return episode.label, episode.group
    known = registry.methods()
    return (known[method].method.label, known[method].method.group) if method in known else (method, "")


def _entry(
    episodes: Episodes,
    method: str,
    metric: str,
    published: Mapping[tuple[str, str], str],
    reference: str,
    absent: Mapping[str, Reason],
) -> Entry:
    printed = published.get((method, metric))
    seeds = episodes.complete_seeds(method)
    reason = missing_episodes(episodes, method, absent) or _missing_value(episodes, method, metric, seeds)
    if reason is not None:
        return Entry(None, None, 0, 0, printed, missing=reason)
    summary = summarise([_scene_values(episodes, method, seed, metric) for seed in seeds])
    against = None if method == reference else _against(episodes, method, reference, metric)
    return Entry(summary.mean, summary.spread, len(episodes.scenes), len(seeds), printed, against)


def _missing_value(episodes: Episodes, method: str, metric: str, seeds: Sequence[int]) -> Reason | None:
    """Say why a metric has no mean over all scenes for these seeds, or return None."""
    for scene in episodes.scenes:
        for seed in seeds:
            if scene_value(episodes, method, scene, seed, metric) is None:
                return Reason(cause=episodes.cells[method][scene, seed].absent.get(metric, "not measured"))
    return None


def _against(episodes: Episodes, method: str, reference: str, metric: str) -> tuple[float, Interval | None] | None:
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
    return mean, paired_bootstrap(differences, confidence=CONFIDENCE)


def _scene_values(episodes: Episodes, method: str, seed: int, metric: str) -> list[float]:
    """Return one value for each scene; the caller has made sure that none is missing."""
    values = [scene_value(episodes, method, scene, seed, metric) for scene in episodes.scenes]
    return [value for value in values if value is not None]
