"""What the tables of a run are made from, by its plan: each record with the logs that tell why it is not there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from avs.config.jobs import settings_of
from avs.config.method_weights import Made, absent_methods, followed, is_program, weights_of
from avs.config.paper_tables import FOLDER, published_scenes, side_by_side, with_memory
from avs.config.report_jobs import CoverageTableJob, RowsJob, SummaryJob, TableJob
from avs.config.run_plan import RunPlan
from avs.config.slam_config import SlamFigureJob, explorers
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
from avs.system.ledger import why_left_out
from avs.system.reasons import Reason


def unfinished(plan: RunPlan) -> UnfinishedRun:
    """Return what the tables of a run are made from, whether it is there or not."""
    config = plan.config
    return UnfinishedRun(
        reference=config.report.reference,
        absent=absent_methods(config),
        tables=tuple(_table(plan, dataset) for dataset in config.evaluated),
        times=None if plan.timed is None else _times(plan, *plan.timed),
        sensitivity=tuple(_wanted_sensitivity(plan)),
        side_by_side=side_by_side(config),
        coverage=tuple(_coverage(plan, dataset) for dataset in config.with_table("coverage")),
        explorations=_explorations(plan),
        scorers=wanted_scorers(plan),
        agnostic=tuple(wanted_agnostic(plan, partial(_episode_beside, plan, "agnostic_episode", "representation"))),
    )


def _explorations(plan: RunPlan) -> WantedExplorations | None:
    """Return what the table of active SLAM is made from where the run makes it with the others, or has begun it."""
    told, rule = plan.config.slam, "exploration"
    if told is None or not told.buildings:
        return None
    settings = settings_of(plan.config, "slam_figure")
    assert isinstance(settings, SlamFigureJob)
    runs = explored(plan.config).items()
    records = []
    for building, method, seed in ((name, each, seed) for name, of in runs for each in of for seed in settings.seeds):
        place = {"building": building, "method": method, "seed": seed}
        logs = _exploration_logs(plan, place)
        records.append(
            WantedExploration(
                place=(building, method, seed),
                path=Path(plan.records[rule].format(**place)),
                logs=logs,
                settings=settings_of(plan.config, f"{rule}/{building}/{method}").model_dump(mode="json"),
                stale=why_left_out(logs, plan.stamps),
            )
        )
    if not told.with_tables and not any(each.path.exists() for each in records):
        return None
    published = Path(f"{FOLDER}/{SLAM_NAME}")
    absent = settings.absent, settings.absent_buildings
    return WantedExplorations(settings.buildings, settings.in_order, tuple(records), published, *absent)


def _exploration_logs(plan: RunPlan, place: dict[str, Any]) -> tuple[Path, ...]:
    """Return the logs of an exploration's job and of those that it waits for."""
    chooser = explorers(plan.config.slam).get(place["method"])
    logs = [plan.logs[rule].format(**place) for rule in ("exploration", "building", "kernels")]
    return tuple(map(Path, [*logs, *([] if chooser is None else _logs_of_weights(plan, chooser.method))]))


def _coverage(plan: RunPlan, dataset: str) -> WantedCoverageTable:
    settings = settings_of(plan.config, f"coverage_table/{dataset}")
    assert isinstance(settings, CoverageTableJob)
    places = [
        {"dataset": dataset, "scene": scene, "method": method, "seed": str(seed)}
        for method in settings.methods
        if method not in settings.absent
        for scene in plan.scenes[dataset]
        for seed in plan.config.seeds
    ]
    return WantedCoverageTable(
        dataset=dataset,
        methods=settings.methods,
        records=tuple(
            WantedCoverage(
                method=place["method"],
                cell=(place["scene"], int(place["seed"])),
                path=Path(plan.records["coverage"].format(**place)),
                logs=logs,
                stale=why_left_out(logs, plan.stamps),
            )
            for place in places
            for logs in [_logs(plan, ["coverage", "coverage_reference", "stereo_kernels"], place)]
        ),
        settings=settings_of(plan.config, "coverage").model_dump(mode="json"),
        published=None if settings.published is None else Path(settings.published),
        lacking=settings.lacking,
    )


def _wanted_sensitivity(plan: RunPlan) -> Iterator[WantedSensitivity]:
    """Yield the sensitivity tables that the run makes with the others, and those that have been begun."""
    told, absent = plan.config.sensitivity, absent_methods(plan.config)
    if told is None:
        return
    for dataset, scenes in plan.studied.items():
        methods = studied_methods(plan.config, dataset)
        settings = {
            name: tuple(
                _studied_episode(plan, name, method, dataset, scene, seed)
                for method in methods
                if method not in absent
                for scene in scenes
                for seed in told.seeds or plan.config.seeds
            )
            for name in (BASE, *told.variants)
        }
        varied = (each for name, episodes in settings.items() if name != BASE for each in episodes)
        if told.with_tables or any(each.path.exists() for each in varied):
            yield WantedSensitivity(dataset, methods, settings)


def _studied_episode(plan: RunPlan, name: str, method: str, dataset: str, scene: str, seed: int) -> WantedEpisode:
    if name == BASE:
        return _episode(plan, method, dataset, scene, seed)
    place = {"variant": name, "method": method, "dataset": dataset, "scene": scene, "seed": str(seed)}
    return _episode_beside(plan, "sensitivity_episode", "variant", place)


def _episode_beside(plan: RunPlan, rule: str, beside: str, place: dict[str, str]) -> WantedEpisode:
    """Return what is to be known of an episode of another rule than ``episode``; ``beside`` is its further wildcard."""
    own = _episode(plan, place["method"], place["dataset"], place["scene"], int(place["seed"]))
    settings = settings_of(plan.config, f"{rule}/{place[beside]}/{place['method']}")
    assert isinstance(settings, EpisodeSettings)
    logs = (Path(plan.logs[rule].format(**place)), *own.logs[1:])
    path, stale = Path(plan.records[rule].format(**place)), why_left_out(logs, plan.stamps)
    return replace(own, path=path, logs=logs, settings=_recorded(settings), stale=stale)


def _recorded(settings: EpisodeSettings) -> dict[str, Any]:
    """Return the settings that an episode's record repeats, by the record's keys."""
    told: dict[str, Any] = settings.model_dump(mode="json", include={"protocol", "representation"})
    if is_program(settings.method) or followed(settings.method) is not None:
        return told
    return told | {"selector": registry.create_settings(settings.method, settings.selector).model_dump(mode="json")}


def _table(plan: RunPlan, dataset: str) -> WantedTable:
    settings = settings_of(plan.config, f"nvs_table/{dataset}")
    assert isinstance(settings, TableJob)
    return WantedTable(
        dataset=dataset,
        methods=settings.methods,
        episodes=tuple(
            _episode(plan, method, dataset, scene, seed)
            for method in settings.methods
            if method not in settings.absent
            for scene in plan.scenes[dataset]
            for seed in plan.config.seeds
        ),
        published=None if settings.published is None else Path(settings.published),
        left_out=settings.left_out,
        pictures=settings.pictures,
        published_scenes=tuple(map(Path, published_scenes(plan.config, dataset))),
        states=tuple(_states(plan, dataset)) if dataset in plan.config.with_table("ranking") else (),
        unscored=_unscored(plan, dataset),
    )


def _unscored(plan: RunPlan, dataset: str) -> dict[str, Reason]:
    settings = settings_of(plan.config, f"ranking_table/{dataset}")
    assert isinstance(settings, RowsJob)
    return settings.absent


def _states(plan: RunPlan, dataset: str) -> Iterator[WantedStates]:
    settings = settings_of(plan.config, f"common_states/{dataset}")
    assert isinstance(settings, CommonStatesJob)
    told = settings.model_dump(mode="json", include={"protocol", "representation", "common_states"})
    for scene in plan.scenes[dataset]:
        for seed in plan.config.seeds:
            place = {"dataset": dataset, "scene": scene, "seed": str(seed)}
            waited = [_logs(plan, ["common_states"], place | {"method": each.method}) for each in settings.methods]
            own = _logs(plan, ["common_states"], place)
            logs = tuple(dict.fromkeys(log for logs in (own, *waited) for log in logs))
            yield WantedStates(
                path=Path(plan.records["common_states"].format(**place)),
                scene=Path(plan.records["scene"].format(**place)),
                logs=logs,
                cell=(scene, seed),
                settings={"settings" if name == "common_states" else name: value for name, value in told.items()},
                stale=why_left_out(logs, plan.stamps),
            )


def _episode(plan: RunPlan, method: str, dataset: str, scene: str, seed: int) -> WantedEpisode:
    settings = settings_of(plan.config, f"episode/{method}")
    assert isinstance(settings, EpisodeSettings)
    place = {"method": method, "dataset": dataset, "scene": scene, "seed": str(seed)}
    logs = _episode_logs(plan, place)
    return WantedEpisode(
        method=method,
        path=Path(plan.records["episode"].format(**place)),
        scene=Path(plan.records["scene"].format(**place)),
        logs=logs,
        cell=(scene, seed),
        settings=_recorded(settings),
        stale=why_left_out(logs, plan.stamps),
    )


def _episode_logs(plan: RunPlan, place: dict[str, str]) -> tuple[Path, ...]:
    """Return the logs of an episode's job and those before it, the episode that it follows among them."""
    method = place["method"]
    own, other = _logs(plan, ["episode", *(["views"] if is_program(method) else [])], place), followed(method)
    return own if other is None else tuple(dict.fromkeys((*own, *_episode_logs(plan, place | {"method": other}))))


def _times(plan: RunPlan, dataset: str, scene: str) -> WantedTimes:
    settings = settings_of(plan.config, "runtime_table")
    assert isinstance(settings, RowsJob)
    places = [
        {"method": method, "dataset": dataset, "scene": scene}
        for method in settings.methods
        if method not in settings.absent
    ]
    return WantedTimes(
        dataset=dataset,
        methods=settings.methods,
        scene=scene,
        records=tuple(
            WantedRecord(
                method=place["method"],
                path=Path(plan.records["runtime"].format(**place)),
                scene=Path(plan.records["scene"].format(**place)),
                logs=logs,
                stale=why_left_out(logs, plan.stamps),
            )
            for place in places
            for logs in [_logs(plan, ["runtime", "runtime_state"], place)]
        ),
        absent=settings.absent,
        published=tuple(map(Path, plan.published_times)),
        summaries=_summaries(plan, dataset),
    )


def _summaries(plan: RunPlan, dataset: str) -> dict[Summary, tuple[tuple[str, ...], Path]]:
    names: tuple[Summary, ...] = ("memory", "detail") if with_memory(plan.config, dataset) else ("detail",)
    found: dict[Summary, tuple[tuple[str, ...], Path]] = {}
    for name in names:
        settings = settings_of(plan.config, f"runtime_summary/{name}")
        assert isinstance(settings, SummaryJob)
        found[name] = (settings.methods, Path(settings.published))
    return found


def _logs(plan: RunPlan, own: list[str], place: dict[str, str]) -> tuple[Path, ...]:
    """Return the logs of a job's own rules, then of the jobs that make what all jobs of its scene and method need."""
    logs = [plan.logs[rule].format(**place) for rule in [*own, "scene", "kernels"]]
    return tuple(map(Path, [*logs, *(_logs_of_weights(plan, place["method"]) if "method" in place else [])]))


def _logs_of_weights(plan: RunPlan, method: str) -> list[str]:
    """Return the logs of the jobs that make the weights of a method, if any do."""
    made = weights_of(plan.config, method)
    if not isinstance(made, Made):
        return []
    rules = ("scene",) if made.rule == "niqe_fit" else ("distortions", "scene")
    datasets = () if plan.config.distortions is None else plan.config.distortions.datasets
    return [
        plan.logs[made.rule].format(scorer=made.name),
        *(
            plan.logs[rule].format(dataset=dataset, scene=scene)
            for dataset in datasets
            for scene in plan.scenes[dataset]
            for rule in rules
        ),
    ]
