"""What the jobs that make the page read of the configuration."""

from __future__ import annotations

from collections.abc import Callable

from avs.config.method_weights import absent_methods
from avs.config.report_jobs import PageExplorationJob, PageJob, PageSceneJob
from avs.config.run_config import Config
from avs.config.scenes import scenes_in
from avs.config.shown_records import records_of, rows_of
from avs.config.slam_jobs import explored
from avs.system.models import StrictModel


def _page_scene(config: Config, dataset: str) -> PageSceneJob:
    """Return what the part of the page of each scene of a data set reads."""
    episodes = sum(len(config.methods_on(name)) * len(scenes_in(config.datasets[name])) for name in config.evaluated)
    share = len(config.methods_on(dataset)) / max(episodes, 1)
    return PageSceneJob(**rows_of(config, dataset), page=config.report.page, share=share)


def _page_exploration(config: Config, _: str) -> PageExplorationJob:
    return PageExplorationJob(page=config.report.page)


def _page(config: Config, _: str) -> PageJob:
    """Return what the page reads; explorations are on it where the target ``tables`` makes their table, too."""
    slam = config.slam
    explorations = {}
    if slam is not None and slam.with_tables:
        explorations = {
            building: tuple((name, seed) for name in methods for seed in slam.seeds)
            for building, methods in explored(config).items()
        }
    return PageJob(
        **records_of(config),
        absent=absent_methods(config),
        scale=config.scale,
        data_sets=config.evaluated,
        config=config.model_dump(mode="json"),
        explorations=explorations,
    )


PAGE_JOBS: dict[str, Callable[[Config, str], StrictModel]] = {
    "page_scene": _page_scene,
    "page_exploration": _page_exploration,
    "page": _page,
}
"""A part of ``avs.config.jobs.JOBS``."""
