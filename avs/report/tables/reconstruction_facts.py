"""Under which settings scenes were reconstructed for the numbers of a table: what captions and notes say of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from avs.nvs.record import Episode
from avs.report.collect import Episodes, common_settings
from avs.report.tables.changed_settings import differences
from avs.report.tables.table_notes import span, spanned


def loop_facts(episodes: Episodes) -> list[str]:
    """Return how many test images, views and iterations there were."""
    return [
        f"{spanned((len(episode.curve[-1].images) for episode in episodes.all), 'test image')} a scene",
        f"{span(episode.budget for episode in episodes.all)} views",
        f"{span(len(episode.initial) for episode in episodes.all)} of them initial",
        f"{span(episode.curve[-1].iteration for episode in episodes.all)} iterations",
    ]


def reconstruction(episodes: Episodes) -> str:
    """Return the sentence that says of what images, and as what, scenes were reconstructed."""
    return f"Representation: {'; '.join(filter(None, (_at_the_end(episodes), _images(episodes))))}."


def column_facts(columns: Mapping[str, Episodes]) -> list[str]:
    """Return the sentences of a caption that say the same of each column of a table, columns that share it together."""
    loops: dict[str, list[str]] = {}
    having = {name: episodes for name, episodes in columns.items() if episodes.all}
    for name, episodes in having.items():
        loops.setdefault(", ".join(filter(None, (*loop_facts(episodes), _images(episodes)))), []).append(name)
    told = [f"{', '.join(names)}: {facts}" if len(loops) > 1 else facts for facts, names in loops.items()]
    ends = [f"{name}: {_at_the_end(episodes)}" for name, episodes in having.items()]
    beginning = "Columns" if len(loops) > 1 else "In all columns"
    return [f"{beginning}: {'; '.join(told)}.", f"Representations: {'; '.join(ends)}."] if having else []


def column_differences(columns: Mapping[str, Episodes]) -> list[str]:
    """Return for each column which settings differ from those of the first column with a representation of its kind.

    Settings of the loop that a method has for itself do not count.
    """
    first: dict[str, tuple[str, dict[str, dict[str, object]]]] = {}
    lines = []
    for name, episodes in columns.items():
        if not episodes.all:
            continue
        settings = {"protocol": common_settings(episodes.all), "representation": episodes.all[0].representation}
        usual, of_usual = first.setdefault(_kind(episodes.all[0]), (name, settings))
        told = differences(settings, of_usual)
        if told:
            lines.append(f"{name}, not as {usual}: {told}")
    return lines


def with_primitives(kinds: Iterable[str], primitives: Iterable[int], when: str = "") -> str:
    """Return ``gaussians, 3000 primitives`` and when they were counted, or ``tensorf``: a field has none."""
    numbers = list(primitives)
    told = ", ".join(sorted(set(kinds)))
    return f"{told}, {span(numbers)} primitives{when}" if any(numbers) else told


def _at_the_end(episodes: Episodes) -> str:
    primitives = (episode.curve[-1].primitives for episode in episodes.all)
    return with_primitives(map(_kind, episodes.all), primitives, " at the end")


def _images(episodes: Episodes) -> str:
    sizes = {max(episode.image_size) for episode in episodes.all if episode.image_size is not None}
    return f"images of {span(sizes)} pixels on the longer side" if sizes else ""


def _kind(episode: Episode) -> str:
    return str(episode.representation.get("kind", "gaussians"))
