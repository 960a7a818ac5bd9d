"""What the jobs of active SLAM read of the configuration, and which methods and buildings have no explorations."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path

from avs.config.method_weights import lacking_weights
from avs.config.run_config import Config
from avs.config.slam_config import (
    BuildingJob,
    MeshBuilding,
    SlamConfig,
    SlamFigureJob,
    exploration_settings,
    explorers,
    slam_figure,
    untrained,
)
from avs.slam.building.usable_mesh import check_building
from avs.slam.loop.slam_settings import SlamSettings
from avs.system.errors import UserError
from avs.system.models import StrictModel
from avs.system.reasons import Reason


def _slam(config: Config) -> SlamConfig:
    if config.slam is None:
        raise LookupError("no explorations")  # settings of an earlier run may be there
    return config.slam


def _building(config: Config, name: str) -> BuildingJob:
    return BuildingJob(building=_slam(config).buildings[name])


def _exploration(config: Config, name: str) -> SlamSettings:
    building, method = name.split("/")
    return exploration_settings(_slam(config), building, method)


def _slam_figure(config: Config, _: str) -> SlamFigureJob:
    return slam_figure(_slam(config), absent_explorers(config), absent_buildings(config))


def absent_explorers(config: Config) -> dict[str, Reason]:
    """Return why each method of Task A that is to explore cannot run here, by the identifier that it has there."""
    lacking = untrained(config.slam, config.scorers)
    able = {name: told for name, told in explorers(config.slam).items() if name not in lacking}
    answers = {name: lacking_weights(config, told.method) for name, told in able.items()}
    return lacking | {name: reason for name, reason in answers.items() if reason is not None}


def absent_buildings(config: Config) -> dict[str, Reason]:
    """Return why each building that cannot be read is not explored, by its name; one keeps no other from it."""
    buildings = {} if config.slam is None else config.slam.buildings
    files = {name: Path(each.file) for name, each in buildings.items() if isinstance(each, MeshBuilding)}
    reasons = {name: _why_unusable(path) for name, path in files.items()}
    return {name: reason for name, reason in reasons.items() if reason is not None}


def explored(config: Config) -> dict[str, list[str]]:
    """Return the methods that explore here, in order, by the names of the buildings; empty where none does."""
    if config.slam is None:
        return {}
    unable, unread = absent_explorers(config), absent_buildings(config)
    methods = [name for name in config.slam.methods if name not in unable]
    return {name: methods for name in config.slam.buildings if name not in unread} if methods else {}


@functools.cache
def _why_unusable(path: Path) -> Reason | None:
    """Return why a mesh cannot be read, or None; a process looks once, so that all of a run goes by the same."""
    try:
        check_building(path)
    except UserError as error:
        return Reason(cause=str(error))
    return None


SLAM_JOBS: dict[str, Callable[[Config, str], StrictModel]] = {
    "building": _building,
    "exploration": _exploration,
    "slam_figure": _slam_figure,
}
"""A part of ``avs.config.jobs.JOBS``."""
