"""Episodes that are not there: why a row has no mean or one of fewer seeds, and what an incomplete table says.

A mean is never taken over the scenes that happen to be there: a seed counts only with every scene of the table, which
are those of any method.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from avs.report.collect import Cell, Episodes
from avs.report.methods import presented
from avs.system.reasons import Reason


def missing_row(episodes: Episodes, method: str, absent: Mapping[str, Reason]) -> Reason | None:
    """Return why a method has no seed with an episode of every scene, or None if it has one.

    Args:
        episodes: the episodes of one data set.
        method: identifier.
        absent: why a method could not run, by identifier.
    """
    if episodes.complete_seeds(method):
        return None
    lacking = episodes.lacking(method)
    told = _told(lacking, episodes)
    details = "; ".join(f"{places}: {why}" for why, places in told.items())
    if not episodes.cells.get(method):
        remedy = next(iter(told)) if len(told) == 1 else details
        return absent.get(method, Reason(cause=f"no {episodes.counted[0]}", remedy=remedy or None))
    scenes = [scene for scene in episodes.scenes if scene not in {each for each, _ in episodes.cells[method]}]
    if not scenes:
        return Reason(cause=f"no {episodes.counted[0]} of every scene for any seed", remedy=details or None)
    whole = {scene for scene, _ in lacking} == set(scenes)
    remedy = next(iter(told)) if whole and len(told) == 1 else details
    return Reason(cause=f"no {episodes.counted[0]} of {', '.join(scenes)}", remedy=remedy or None)


def fewer_seeds(episodes: Episodes, method: str) -> str | None:
    """Return which seeds the mean of a method leaves out, and why, or None if it has all or no mean."""
    seeds, lacking = episodes.complete_seeds(method), episodes.lacking(method)
    if not seeds or not lacking:
        return None
    told = _told(lacking, episodes)
    unexplained = _places((cell for cell, why in lacking.items() if why is None), episodes)
    details = [f"{places}: {why}" for why, places in told.items()] + ([unexplained] if unexplained else [])
    return f"mean of {_seeds(seeds)} only, not to be ranked, no {episodes.counted[0]} of {'; '.join(details)}"


def incomplete(episodes: Episodes) -> list[str]:
    """Return sentences that begin the caption of an incomplete table; none for a complete one."""
    missing = missing_episodes(episodes)
    if missing is None:
        return []
    sentences = [f"Incomplete: {missing}."]
    names = [*_scenes_left_out(episodes), *(f"seed {seed}" for seed in _seeds_left_out(episodes))]
    if names:
        sentences.append(f"Left out, because no method has one there: {', '.join(names)}.")
    return sentences


def missing_episodes(episodes: Episodes) -> str | None:
    """Return how many episodes are missing, or None if all are there."""
    missing = sum(map(len, episodes.missing.values()))
    verb = "is" if missing == 1 else "are"
    return f"{missing} of {missing + len(episodes.all)} {episodes.counted[1]} {verb} missing" if missing else None


def left_out(episodes: Episodes) -> list[str]:
    """Return a note for each scene and seed without any episode: why."""
    gaps = [(method, cell, why) for method, cells in episodes.missing.items() for cell, why in cells.items()]
    places: dict[str, list[tuple[str, str]]] = {
        scene: [(method, why) for method, cell, why in gaps if cell[0] == scene] for scene in _scenes_left_out(episodes)
    }
    for seed in _seeds_left_out(episodes):
        places[f"seed {seed}"] = [(method, why) for method, cell, why in gaps if cell[1] == seed]
    return [line for place, found in places.items() for line in _by_reason(place, found, episodes)]


def _by_reason(place: str, gaps: Iterable[tuple[str, str]], episodes: Episodes) -> list[str]:
    """Return one line if all methods lack a place for the same reason, else one for each reason with its methods."""
    labels: dict[str, dict[str, None]] = {}
    for method, why in gaps:
        labels.setdefault(why, {})[presented(method, episodes).label] = None
    if len(labels) == 1:
        return [f"{place}: {why}" for why in labels]
    return [f"{place}, {', '.join(methods)}: {why}" for why, methods in labels.items()]


def _scenes_left_out(episodes: Episodes) -> list[str]:
    wanted = {scene for cells in episodes.missing.values() for scene, _ in cells}
    return sorted(wanted - set(episodes.scenes))


def _seeds_left_out(episodes: Episodes) -> list[int]:
    wanted = {seed for cells in episodes.missing.values() for _, seed in cells}
    return sorted(wanted - set(episodes.seeds))


def _told(lacking: Mapping[Cell, str | None], episodes: Episodes) -> dict[str, str]:
    """Return the known reasons, and which scenes and seeds each of them concerns."""
    reasons = dict.fromkeys(why for why in lacking.values() if why is not None)
    return {why: _places((cell for cell, each in lacking.items() if each == why), episodes) for why in reasons}


def _places(cells: Iterable[Cell], episodes: Episodes) -> str:
    seeds: dict[str, list[int]] = {}
    for scene, seed in cells:
        seeds.setdefault(scene, []).append(seed)
    return ", ".join(
        scene if found == episodes.seeds else f"{scene} with {_seeds(found)}" for scene, found in seeds.items()
    )


def _seeds(seeds: list[int]) -> str:
    return f"seed{'s' if len(seeds) > 1 else ''} {', '.join(map(str, seeds))}"
