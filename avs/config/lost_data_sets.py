"""Data sets whose scenes cannot be listed, as of a folder that is not there: one keeps no other from its tables."""

from __future__ import annotations

from typing import Any

from avs.config.run_config import Config, DataSet
from avs.config.scenes import scenes_in
from avs.system.errors import UserError


def without_lost(config: Config) -> tuple[Config, dict[str, str]]:
    """Return ``config`` without what is lost, and why, by the name of the data set or the section.

    Lost are data sets on which methods run and whose scenes cannot be listed, and what names one of their scenes or
    them alone. Where all of them are, ``config`` is returned as it is, and ``scenes_of`` tells of the first; data for
    scorers is not looked at, since methods need it.
    """
    names = (*config.evaluated, *config.without_methods)
    reasons = {name: _why_lost(config.datasets[name]) for name in names}
    lost = {name: reason for name, reason in reasons.items() if reason is not None}
    if not lost or lost.keys() >= set(config.evaluated):
        return config, {}
    kept = {name: dataset for name, dataset in config.datasets.items() if name not in lost}
    changes, sections = _of_sections(config, lost)
    return config.model_copy(update={"datasets": kept, **changes}), lost | sections


def _why_lost(dataset: DataSet) -> str | None:
    try:
        scenes_in(dataset)
    except UserError as error:
        return str(error)
    return None


def _of_sections(config: Config, lost: dict[str, str]) -> tuple[dict[str, Any], dict[str, str]]:
    """Return what becomes of sections that name a scene or a data set, and why one of them is left out."""
    there = {name: scenes_in(config.datasets[name]) for name in config.evaluated if name not in lost}
    known = {each for name, scenes in there.items() for scene in scenes for each in (scene, f"{name}/{scene}")}
    changes: dict[str, Any] = {}
    reasons: dict[str, str] = {}
    if config.runtime is not None and config.runtime.scene not in (None, *known):
        changes["runtime"] = None
        reasons["runtime"] = f"its scene {config.runtime.scene} is none of those that are there"
    if config.coverage is not None and config.coverage.scene not in (None, *known):
        changes["coverage"] = config.coverage.model_copy(update={"scene": None})
        reasons["coverage.scene"] = f"{config.coverage.scene} is none of those that are there; the first is drawn"
    if config.sensitivity is not None and config.sensitivity.scenes is not None:
        scenes = tuple(each for each in config.sensitivity.scenes if each in known)
        changes["sensitivity"] = config.sensitivity.model_copy(update={"scenes": scenes}) if scenes else None
        if not scenes:
            reasons["sensitivity"] = "none of its scenes is there"
    if config.agnostic is not None and config.agnostic.datasets is not None:
        names = tuple(each for each in config.agnostic.datasets if each not in lost)
        changes["agnostic"] = config.agnostic.model_copy(update={"datasets": names}) if names else None
        if not names:
            reasons["agnostic"] = "none of its data sets is there"
    return changes, reasons
