"""What the records themselves tell a reader of their means: notes, settings of one method, views that never differ."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence

from avs.nvs.record import Episode
from avs.report.collect import Cell, Episodes, differing_settings
from avs.report.machines import machine_notes
from avs.report.methods import presented
from avs.report.tables.changed_settings import changed_settings

_OPTIMISATION = (
    "what differs between seeds is the noise of the optimisation alone",
    "what differs between these rows is the optimisation alone",
)


def repeated_notes(episodes: Episodes) -> list[str]:
    """Return the notes of all episodes, each once; one that several scenes share names them in front."""
    return grouped_notes(((each.scene, note) for each in episodes.all for note in each.notes), episodes.scenes)


def grouped_notes(notes: Iterable[tuple[str, str]], scenes: Collection[str]) -> list[str]:
    """Return each note once; one that begins with its scene and is that of others, too, names all of them.

    Args:
        notes: the scene of a record, and a note of it.
        scenes: all scenes of the table.
    """
    places: dict[str, dict[str, None]] = {}
    for scene, note in notes:
        named = note.startswith(f"{scene}: ")
        text = note.removeprefix(f"{scene}: ") if named else note
        places.setdefault(text, {}).update({scene: None} if named else {})
    lines = []
    for text, found in places.items():
        names = "every scene" if len(found) > 1 and set(found) == set(scenes) else ", ".join(sorted(found))
        lines.append(f"{names}: {text}" if names else text)
    return lines


def episode_notes(episodes: Episodes) -> list[str]:
    """Return what sets some episodes of a data set apart from others, and the notes of all of them."""
    return [
        *own_schedules(episodes),
        *own_settings(episodes),
        *machine_notes(episodes.records),
        *repeated_notes(episodes),
    ]


def notes_of_method(episodes: Episodes, method: str) -> list[str]:
    """Return the notes of one method's episodes, each once, in order."""
    return sorted({note for episode in episodes.cells[method].values() for note in episode.notes})


def own_schedules(episodes: Episodes) -> list[str]:
    """Return a line for each method whose settings of the loop are not those of most methods."""
    return [
        f"{presented(method, episodes).label} has settings of the loop for itself, which are part of its row: "
        + ", ".join(f"{key} {own}" + ("" if usual is None else f" instead of {usual}") for key, own, usual in differing)
        for method, differing in differing_settings(episodes).items()
    ]


def own_settings(episodes: Episodes) -> list[str]:
    """Return which settings of methods are not their defaults, methods that share them together.

    A row has a method's name, whatever its settings; those of a program are not known.
    """
    found: dict[str, list[str]] = {}
    for method, cells in episodes.cells.items():
        told = "; ".join(dict.fromkeys(changed_settings(method, episode.selector) for episode in cells.values()))
        if told:
            found.setdefault(told, []).append(method)
    return [f"{_labels(methods, episodes)}, not as by default: {told}" for told, methods in found.items()]


def equal_views(episodes: Episodes, *, of_views_alone: bool = False) -> list[str]:
    """Return which methods choose the same views with every seed, and which choose the same as another method.

    What differs between such episodes is the optimisation alone, in random order and with random numbers of its own.

    Args:
        episodes: of one data set.
        of_views_alone: whether the numbers follow from the views, so that equal views have equal numbers.
    """
    told = (
        ("so its numbers do not differ between seeds", "so these rows are equal") if of_views_alone else _OPTIMISATION
    )
    fixed = [method for method, cells in episodes.cells.items() if _same_with_every_seed(cells)]
    lines = []
    if fixed:
        lines.append(f"{_labels(fixed, episodes)}: the same views with every seed; {told[0]}")
    for methods in _grouped(episodes):
        lines.append(f"{_labels(methods, episodes)}: the same views in every episode; {told[1]}")
    return lines


def _same_with_every_seed(cells: Mapping[Cell, Episode]) -> bool:
    by_scene: dict[str, list[list[str]]] = {}
    for (scene, _), episode in cells.items():
        by_scene.setdefault(scene, []).append(_views(episode))
    repeated = [views for views in by_scene.values() if len(views) > 1]
    return bool(repeated) and all(each == views[0] for views in repeated for each in views)


def _grouped(episodes: Episodes) -> list[list[str]]:
    """Return the methods that share all their views with another, in groups."""
    groups: dict[Hashable, list[str]] = {}
    for method, cells in episodes.cells.items():
        key = tuple((cell, tuple(_views(episode))) for cell, episode in cells.items())
        groups.setdefault(key, []).append(method)
    return [methods for methods in groups.values() if len(methods) > 1]


def _views(episode: Episode) -> list[str]:
    return [*episode.initial, *episode.selected]


def _labels(methods: Iterable[str] | Sequence[str], episodes: Episodes) -> str:
    return ", ".join(presented(method, episodes).label for method in methods)
