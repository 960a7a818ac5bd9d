"""What the jobs of active SLAM read of the configuration, and which methods cannot explore."""

from __future__ import annotations

from collections.abc import Callable

from avs.config.method_weights import Absent, weights_of
from avs.config.run_config import Config
from avs.config.slam_config import (
    BuildingJob,
    SlamConfig,
    SlamFigureJob,
    exploration_settings,
    explorers,
    slam_figure,
    untrained,
)
from avs.slam.loop.slam_settings import SlamSettings
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
    return slam_figure(_slam(config), absent_explorers(config))


def absent_explorers(config: Config) -> dict[str, Reason]:
    """Return why each method of Task A that is to explore cannot run here, by the identifier that it has there."""
    lacking = untrained(config.slam, config.scorers)
    able = {name: told for name, told in explorers(config.slam).items() if name not in lacking}
    answers = {name: weights_of(config, told.method) for name, told in able.items()}
    return lacking | {name: answer.reason for name, answer in answers.items() if isinstance(answer, Absent)}


SLAM_JOBS: dict[str, Callable[[Config, str], StrictModel]] = {
    "building": _building,
    "exploration": _exploration,
    "slam_figure": _slam_figure,
}
"""A part of ``avs.config.jobs.JOBS``."""
