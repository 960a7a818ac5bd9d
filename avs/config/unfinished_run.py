"""What the tables of a run are made from, by its plan: each record with the logs that tell why it is not there."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from avs.config.jobs import settings_of
from avs.config.method_weights import absent_methods, followed, is_program
from avs.config.paper_tables import FOLDER, published_scenes, side_by_side, with_memory
from avs.config.planned_jobs import Place, PlannedJob, PlannedJobs, planned_jobs
from avs.config.report_jobs import CoverageTableJob, RowsJob, SummaryJob, TableJob
from avs.config.run_plan import RunPlan
from avs.config.slam_config import SlamFigureJob
from avs.config.slam_jobs import explored
from avs.config.studied import studied_methods
from avs.config.unfinished_agnostic import wanted_agnostic
from avs.config.unfinished_scorers import wanted_scorers
from avs.nvs.common_states_settings import CommonStatesJob
from avs.nvs.episode_settings import EpisodeSettings
from avs.report.incomplete_coverage import WantedCoverage, WantedCoverageTable
from avs.report.incomplete_explorations import WantedExploration, WantedExplorations
from avs.report.published import SLAM_NAME
from avs.report.report_settings import BASE
from avs.report.tables.runtime_summary import Summary
from avs.report.wanted_records import (
    UnfinishedRun,
    WantedEpisode,
    WantedRecord,
    WantedSensitivity,
    WantedStates,
    WantedTable,
    WantedTimes,
)
from avs.selection import registry


def unfinished(plan: RunPlan) -> UnfinishedRun:
    """Return what the tables of a run are made from, whether it is there or not."""
    config, jobs = plan.config, planned_jobs(plan)
    return UnfinishedRun(
        reference=config.report.reference,
        absent=absent_methods(config),
        tables=tuple(_table(jobs, dataset) for dataset in config.evaluated),
        times=None if plan.timed is None else _times(jobs, *plan.timed),
        sensitivity=tuple(_wanted_sensitivity(jobs)),
        side_by_side=side_by_side(config),
        coverage=tuple(_coverage(jobs, dataset) for dataset in config.with_table("coverage")),
        explorations=_explorations(jobs),
        scorers=wanted_scorers(jobs),
        agnostic=tuple(wanted_agnostic(jobs, partial(_episode_beside, jobs, "agnostic_episode", "representation"))),
    )


def _explorations(jobs: PlannedJobs) -> WantedExplorations | None:
    """Return what the table of active SLAM is made from where the run makes it with the others, or has begun it."""
    config, rule = jobs.plan.config, "exploration"
    if config.slam is None or not config.slam.buildings:
        return None
    settings = jobs.settings("slam_figure", SlamFigureJob)
    runs = explored(config).items()
    records = []
    for building, method, seed in ((name, each, seed) for name, of in runs for each in of for seed in settings.seeds):
        job = jobs.job(rule, {"building": building, "method": method, "seed": seed})
        records.append(
            WantedExploration(
                place=(building, method, seed),
                path=job.path,
                logs=job.logs,
                settings=settings_of(config, f"{rule}/{building}/{method}").model_dump(mode="json"),
                stale=job.stale,
            )
        )
    if not config.slam.with_tables and not any(each.path.exists() for each in records):
        return None
    published = Path(f"{FOLDER}/{SLAM_NAME}")
    absent = settings.absent, settings.absent_buildings
    return WantedExplorations(settings.buildings, settings.in_order, tuple(records), published, *absent)


def _coverage(jobs: PlannedJobs, dataset: str) -> WantedCoverageTable:
    settings = jobs.settings(f"coverage_table/{dataset}", CoverageTableJob)
    return WantedCoverageTable(
        dataset=dataset,
        methods=settings.methods,
        records=tuple(
            WantedCoverage(method, (scene, seed), job.path, job.logs, job.stale)
            for method in settings.methods
            if method not in settings.absent
            for scene in jobs.plan.scenes[dataset]
            for seed in jobs.plan.config.seeds
            for job in [jobs.job("coverage", {"dataset": dataset, "scene": scene, "method": method, "seed": seed})]
        ),
        settings=settings_of(jobs.plan.config, "coverage").model_dump(mode="json"),
        published=None if settings.published is None else Path(settings.published),
        lacking=settings.lacking,
    )


def _wanted_sensitivity(jobs: PlannedJobs) -> Iterator[WantedSensitivity]:
    """Yield the sensitivity tables that the run makes with the others, and those that have been begun."""
    config = jobs.plan.config
    told, absent = config.sensitivity, absent_methods(config)
    if told is None:
        return
    for dataset, scenes in jobs.plan.studied.items():
        methods = studied_methods(config, dataset)
        settings = {
            name: tuple(
                _studied_episode(jobs, name, method, dataset, scene, seed)
                for method in methods
                if method not in absent
                for scene in scenes
                for seed in told.seeds or config.seeds
            )
            for name in (BASE, *told.variants)
        }
        varied = (each for name, episodes in settings.items() if name != BASE for each in episodes)
        if told.with_tables or any(each.path.exists() for each in varied):
            yield WantedSensitivity(dataset, methods, settings)


def _studied_episode(jobs: PlannedJobs, name: str, method: str, dataset: str, scene: str, seed: int) -> WantedEpisode:
    if name == BASE:
        return _episode(jobs, method, dataset, scene, seed)
    place = {"variant": name, "method": method, "dataset": dataset, "scene": scene, "seed": str(seed)}
    return _episode_beside(jobs, "sensitivity_episode", "variant", place)


def _episode_beside(jobs: PlannedJobs, rule: str, beside: str, place: Place) -> WantedEpisode:
    """Return what is to be known of an episode of another rule than ``episode``; ``beside`` is its further wildcard."""
    return _wanted_episode(jobs, jobs.job(rule, place), f"{rule}/{place[beside]}/{place['method']}", place)


def _episode(jobs: PlannedJobs, method: str, dataset: str, scene: str, seed: int) -> WantedEpisode:
    place = {"method": method, "dataset": dataset, "scene": scene, "seed": str(seed)}
    return _wanted_episode(jobs, jobs.job("episode", place), f"episode/{method}", place)


def _wanted_episode(jobs: PlannedJobs, job: PlannedJob, settings: str, place: Place) -> WantedEpisode:
    return WantedEpisode(
        method=str(place["method"]),
        path=job.path,
        scene=jobs.record("scene", place),
        logs=job.logs,
        cell=(str(place["scene"]), int(str(place["seed"]))),
        settings=_recorded(jobs.settings(settings, EpisodeSettings)),
        stale=job.stale,
    )


def _recorded(settings: EpisodeSettings) -> dict[str, Any]:
    """Return the settings that an episode's record repeats, by the record's keys."""
    told: dict[str, Any] = settings.model_dump(mode="json", include={"protocol", "representation"})
    if is_program(settings.method) or followed(settings.method) is not None:
        return told
    return told | {"selector": registry.create_settings(settings.method, settings.selector).model_dump(mode="json")}


def _table(jobs: PlannedJobs, dataset: str) -> WantedTable:
    settings = jobs.settings(f"nvs_table/{dataset}", TableJob)
    config = jobs.plan.config
    return WantedTable(
        dataset=dataset,
        methods=settings.methods,
        episodes=tuple(
            _episode(jobs, method, dataset, scene, seed)
            for method in settings.methods
            if method not in settings.absent
            for scene in jobs.plan.scenes[dataset]
            for seed in config.seeds
        ),
        published=None if settings.published is None else Path(settings.published),
        left_out=settings.left_out,
        pictures=settings.pictures,
        published_scenes=tuple(map(Path, published_scenes(config, dataset))),
        states=tuple(_states(jobs, dataset)) if dataset in config.with_table("ranking") else (),
        unscored=jobs.settings(f"ranking_table/{dataset}", RowsJob).absent,
    )


def _states(jobs: PlannedJobs, dataset: str) -> Iterator[WantedStates]:
    settings = jobs.settings(f"common_states/{dataset}", CommonStatesJob)
    told = settings.model_dump(mode="json", include={"protocol", "representation", "common_states"})
    for scene in jobs.plan.scenes[dataset]:
        for seed in jobs.plan.config.seeds:
            place = {"dataset": dataset, "scene": scene, "seed": str(seed)}
            job = jobs.job("common_states", place)
            yield WantedStates(
                path=job.path,
                scene=jobs.record("scene", place),
                logs=job.logs,
                cell=(scene, seed),
                settings={"settings" if name == "common_states" else name: value for name, value in told.items()},
                stale=job.stale,
            )


def _times(jobs: PlannedJobs, dataset: str, scene: str) -> WantedTimes:
    settings = jobs.settings("runtime_table", RowsJob)
    place = {"dataset": dataset, "scene": scene}
    return WantedTimes(
        dataset=dataset,
        methods=settings.methods,
        scene=scene,
        records=tuple(
            WantedRecord(method, job.path, jobs.record("scene", place), job.logs, stale=job.stale)
            for method in settings.methods
            if method not in settings.absent
            for job in [jobs.job("runtime", place | {"method": method})]
        ),
        absent=settings.absent,
        published=tuple(map(Path, jobs.plan.published_times)),
        summaries=_summaries(jobs, dataset),
    )


def _summaries(jobs: PlannedJobs, dataset: str) -> dict[Summary, tuple[tuple[str, ...], Path]]:
    names: tuple[Summary, ...] = ("memory", "detail") if with_memory(jobs.plan.config, dataset) else ("detail",)
    found: dict[Summary, tuple[tuple[str, ...], Path]] = {}
    for name in names:
        settings = jobs.settings(f"runtime_summary/{name}", SummaryJob)
        found[name] = (settings.methods, Path(settings.published))
    return found
