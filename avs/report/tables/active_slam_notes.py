"""The notes below the table of active SLAM: what is missing, why, and what its numbers are not to be compared with."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from avs.report.collect_explorations import Explorations
from avs.report.machines import differing
from avs.report.tables.changed_settings import changed_chooser
from avs.system.reasons import Reason


def gaps(explorations: Explorations) -> list[str]:
    """Return a note for each reason why explorations are missing, and for each mean of fewer seeds."""
    gaps: dict[str, list[str]] = {}
    for (building, method, seed), why in explorations.missing.items():
        gaps.setdefault(why, []).append(f"{explorations.label(method)} in {building}, seed {seed}")
    notes = [f"{'; '.join(places)}: {why}" for why, places in gaps.items()]
    for building, method in dict.fromkeys(place[:2] for place in explorations.missing):
        seeds = [str(record.seed) for record in explorations.of(building, method)]
        if seeds:
            plural = "s" if len(seeds) > 1 else ""
            label = explorations.label(method)
            notes.append(f"{label} in {building}: mean of seed{plural} {', '.join(seeds)} only, not to be ranked")
    return notes


def _storeys(explorations: Explorations) -> list[str]:
    """Return a note for each building in which seeds start on different storeys: their surfaces are not the same."""
    areas: dict[str, dict[int, float]] = {}
    for (building, _, seed), record in sorted(explorations.cells.items()):
        areas.setdefault(building, {})[seed] = record.floor_area
    told = {building: sorted(set(of.values())) for building, of in areas.items()}
    return [
        f"{building}: seeds start on different storeys ({', '.join(f'{area:.1f}' for area in found)} square metres), "
        "so that means are over different surfaces and poses; slam.buildings.NAME.start fixes one"
        for building, found in told.items()
        if len(found) > 1
    ]


def remarks(explorations: Explorations, methods: Iterable[str]) -> list[str]:
    """Return what the records say of themselves, of storeys, of upper references and of the published values."""
    notes = [note for record in explorations.cells.values() for note in record.notes] + _storeys(explorations)
    notes += [*_changed(explorations), *_idle(explorations)]
    unranked = [explorations.label(method) for method in methods if not explorations.ranked(method)]
    if unranked:
        notes.append(f"{', '.join(unranked)}: knows the building; an upper reference without a rank")
    told = [
        (str(explorations.cells[place].settings.get("device", "cpu")), meta.machine, meta.packages)
        for place, meta in sorted(explorations.metas.items())
    ]
    notes += differing(told, "explorations", timed=True)
    notes.append(
        "published: the paper's values on Gibson, one number each without a spread, for orientation alone: other "
        "buildings, another camera and another mapper, so that no difference is printed"
    )
    return notes


def _changed(explorations: Explorations) -> list[str]:
    """Return which settings of what chooses paths are not their defaults, methods that share them together."""
    found: dict[str, dict[str, None]] = {}
    for (_, method, _), record in sorted(explorations.cells.items()):
        if told := changed_chooser(record.settings["scorer"]):
            found.setdefault(told, {})[explorations.label(method)] = None
    return [f"{', '.join(labels)}, not as by default: {told}" for told, labels in found.items()]


def _idle(explorations: Explorations) -> list[str]:
    """Return a note for each method that chose no path in a building: its row says nothing of it."""
    return [
        f"{explorations.label(method)} in {building}: chose no path with any seed, so that its row has no rank; "
        + "; ".join(dict.fromkeys(record.ended for record in explorations.of(building, method)))
        for building, method in dict.fromkeys(place[:2] for place in explorations.cells)
        if not explorations.chose(building, method)
    ]


def absences(absent: Mapping[str, Reason]) -> list[str]:
    """Return a note for each name of what has no explorations, with the reason."""
    return [f"{name}: {reason}" for name, reason in absent.items()]
