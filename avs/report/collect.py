"""Episode records read for a table or figure, checked to be comparable."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from avs.nvs.record import CurvePoint, Episode
from avs.report.labels import group_of
from avs.system.errors import UserError
from avs.system.records import read_record

Cell = tuple[str, int]
"""A scene and a seed: what two methods are paired on."""


@dataclass(frozen=True)
class Episodes:
    """The episodes of one data set, at most one for each method, scene and seed.

    Attributes:
        dataset: name of the data set.
        cells: by method identifier, then by scene and seed; both in ascending order.
        missing: why an episode that the run asks for is not there, by method, then by scene and seed; empty where the
            run is complete or nothing is known of it.
        records: the files that the episodes were read from.
        places: the same files by method, scene and seed.
        counted: what there is one of for each, in singular and plural: where a table counts what was measured of
            episodes, that may be missing although the episode is there.
    """

    dataset: str
    cells: dict[str, dict[Cell, Episode]]
    missing: Mapping[str, Mapping[Cell, str]] = field(default_factory=dict)
    records: Sequence[Path] = ()
    places: Mapping[tuple[str, str, int], Path] = field(default_factory=dict)
    counted: tuple[str, str] = ("episode", "episodes")

    @property
    def scenes(self) -> list[str]:
        """The scenes of any method, ascending: those that a complete row covers."""
        return sorted({scene for cells in self.cells.values() for scene, _ in cells})

    @property
    def seeds(self) -> list[int]:
        """The seeds of any method, ascending."""
        return sorted({seed for cells in self.cells.values() for _, seed in cells})

    @property
    def all(self) -> list[Episode]:
        """Every episode, by method, scene and seed."""
        return [episode for cells in self.cells.values() for episode in cells.values()]

    def complete_seeds(self, method: str) -> list[int]:
        """Return the seeds, ascending, for which ``method`` has an episode of every scene."""
        cells = self.cells.get(method, {})
        seeds = sorted({seed for _, seed in cells})
        return [seed for seed in seeds if all((scene, seed) in cells for scene in self.scenes)]

    def lacking(self, method: str) -> dict[Cell, str | None]:
        """Return the scenes and seeds of other methods that ``method`` lacks, with the reason where it is known."""
        cells, reasons = self.cells.get(method, {}), self.missing.get(method, {})
        grid = [(scene, seed) for scene in self.scenes for seed in self.seeds]
        return {cell: reasons.get(cell) for cell in grid if cell not in cells}


def read_episodes(paths: Sequence[Path], methods: Sequence[str]) -> list[Episodes]:
    """Read the records at ``paths`` and return them by data set, in ascending order.

    Args:
        paths: ``episode.json`` files.
        methods: identifiers of the methods that may occur.

    Raises:
        UserError: no path is given; a record is missing or does not follow the schema, has no curve, repeats
            another, is of a method that is not listed, or cannot be compared with the others of its data set.
    """
    if not paths:
        raise UserError("episodes", "none given", "pass at least one episode.json")
    places: dict[tuple[str, str, str, int], Path] = {}
    datasets: dict[str, dict[str, dict[Cell, Episode]]] = {}
    for path in paths:
        episode = read_record(path, Episode)
        episode = episode.model_copy(update={"group": group_of(episode.group)})
        key = (episode.dataset, episode.method, episode.scene, episode.seed)
        if key in places:
            raise UserError(path, f"repeats {places[key]}", "pass one episode for each method, scene and seed")
        if episode.method not in methods:
            raise UserError(path, f"method {episode.method!r} is not among the rows", "list it, or leave the file out")
        if not episode.curve or not all(point.images for point in episode.curve):
            raise UserError(path, "curve: holds no test metrics", "delete it and run again")
        places[key] = path
        datasets.setdefault(episode.dataset, {}).setdefault(episode.method, {})[episode.scene, episode.seed] = episode
    common = {
        name: common_settings(each for cells in found.values() for each in cells.values())
        for name, found in datasets.items()
    }
    for (dataset, method, scene, seed), path in places.items():
        _check_comparable(path, datasets[dataset][method][scene, seed], datasets[dataset], common[dataset])
    files = {name: {key[1:]: path for key, path in places.items() if key[0] == name} for name in datasets}
    return [
        Episodes(name, _ordered(datasets[name], methods), records=list(files[name].values()), places=files[name])
        for name in sorted(datasets)
    ]


def read_dataset(paths: Sequence[Path], methods: Sequence[str], dataset: str) -> Episodes:
    """Read the records at ``paths``, which are all of one data set.

    Raises:
        UserError: see ``read_episodes``; or a record is of another data set.
    """
    collected = read_episodes(paths, methods)
    others = [each.dataset for each in collected if each.dataset != dataset]
    if others:
        raise UserError(f"table of {dataset}", f"got episodes of {', '.join(others)}", f"pass those of {dataset} only")
    return collected[0]


def end_of_curve(episode: Episode) -> CurvePoint:
    """Return the point with all views, at the end of the optimisation."""
    return episode.curve[-1]


def image_mean(point: CurvePoint, metric: str) -> float | None:
    """Return the mean of a metric over the test images, or None if an image lacks it.

    Args:
        point: a point of an episode's curve.
        metric: a field of ``avs.nvs.record.ImageMetrics``.
    """
    values = [getattr(image, metric) for image in point.images]
    return None if any(value is None for value in values) else float(np.mean(values))


def common_protocol(episodes: Episodes) -> dict[str, Any]:
    """Return the settings of the loop of the run; one that every method has for itself is that of any of them."""
    nearest = min(episodes.all, key=lambda episode: len(episode.own))
    return {**nearest.protocol, **common_settings(episodes.all)}


def differing_settings(episodes: Episodes) -> dict[str, list[tuple[str, str, str | None]]]:
    """Return by method the settings of the loop that it has for itself: the name, its value, and the run's.

    Methods without any are left out. Where every method has one for itself, the run's is not known: None.
    """
    firsts = {method: next(iter(cells.values())) for method, cells in episodes.cells.items() if cells}
    found: dict[str, list[tuple[str, str, str | None]]] = {}
    for method, episode in firsts.items():
        for key in episode.own:
            usual = [_plain(each.protocol.get(key)) for each in firsts.values() if key not in each.own]
            told = (key, _plain(episode.protocol.get(key)), usual[0] if usual else None)
            found.setdefault(method, []).append(told)
    return found


def _plain(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)


def _ordered(cells: dict[str, dict[Cell, Episode]], methods: Sequence[str]) -> dict[str, dict[Cell, Episode]]:
    return {method: dict(sorted(cells[method].items())) for method in methods if method in cells}


def common_settings(episodes: Iterable[Episode]) -> dict[str, Any]:
    """Return of each setting of the loop its first value that no method has for itself."""
    found: dict[str, Any] = {}
    for episode in episodes:
        for key, value in episode.protocol.items():
            if key not in episode.own:
                found.setdefault(key, value)
    return found


def _check_comparable(
    path: Path, episode: Episode, dataset: dict[str, dict[Cell, Episode]], common: Mapping[str, Any]
) -> None:
    """Compare with the first of the method, and in what the scene decides with the first of the scene.

    Settings of the loop that the method has for itself are those of its other episodes, all others are ``common``: no
    episode stands for all, because one that has a setting for itself could not tell of the others'.
    """
    first = next(iter(next(iter(dataset.values())).values()))
    same_method = next(iter(dataset[episode.method].values()))
    same_scene = next(
        other for cells in dataset.values() for (scene, _), other in cells.items() if scene == episode.scene
    )
    shared = {key: value for key, value in episode.protocol.items() if key not in episode.own}
    expected = {key: value for key, value in common.items() if key not in episode.own}
    for name, own, other in (
        ("protocol", shared, expected),
        ("protocol", episode.protocol, same_method.protocol),
        ("own", sorted(episode.own), sorted(same_method.own)),
        ("group", episode.group, same_method.group),
        ("representation", episode.representation, first.representation),
        ("selector", episode.selector, same_method.selector),
        ("weights_hash", episode.weights_hash, same_method.weights_hash),
        ("scene_hash", episode.scene_hash, same_scene.scene_hash),
        ("budget", episode.budget, same_scene.budget),
        ("test images", _test_images(episode), _test_images(same_scene)),
    ):
        if own != other:
            fault = f"not comparable with other episodes of {episode.dataset}, {_difference(name, own, other)}"
            raise UserError(path, fault, "run all of them with one configuration")


def _difference(name: str, own: object, other: object) -> str:
    """Name the first differing entry, and the values if they are short."""
    if isinstance(own, dict) and isinstance(other, dict):
        key = next(key for key in sorted(own.keys() | other.keys()) if own.get(key) != other.get(key))
        return _difference(f"{name}.{key}", own.get(key), other.get(key))
    text = f"{name}: {own} instead of {other}"
    return text if len(text) <= 100 else f"{name} differs"


def _test_images(episode: Episode) -> list[str]:
    return [image.name for image in end_of_curve(episode).images]
