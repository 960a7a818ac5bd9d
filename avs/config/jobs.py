"""What the jobs of each rule read of the configuration: one typed model per rule, made from the whole.

The workflow writes it as a file that the job depends on, so that a change of the configuration reruns what reads it and
nothing else. The command of the rule's name reads it back. A model that a lower room takes whole is that room's.
"""

from __future__ import annotations

from collections.abc import Callable

from pydantic import Field

from avs.config.agnostic_jobs import agnostic_table
from avs.config.configuration import protocol_of, variant_of
from avs.config.method_weights import scoring_methods
from avs.config.other_representations import on_representation
from avs.config.page_jobs import PAGE_JOBS
from avs.config.paper_tables import FOLDER, published_means, published_scenes, side_by_side, with_memory
from avs.config.report_jobs import (
    CoverageTableJob,
    DataSetJob,
    DrawnJob,
    FigureJob,
    NamedTableJob,
    RowsJob,
    SceneTableJob,
    SensitivityJob,
    SideBySideJob,
    SummaryJob,
    TableJob,
)
from avs.config.run_config import Config, DataSet
from avs.config.scenes import scenes_in, timed_scene
from avs.config.scorer_jobs import SCORER_JOBS
from avs.config.shown_records import records_of, rows_of
from avs.config.slam_jobs import SLAM_JOBS
from avs.config.studied import studied_methods
from avs.coverage.coverage_settings import CoverageJob, CoverageSettings, ReferenceJob
from avs.datasets.folder_reader import FolderReader
from avs.nvs.common_states_settings import CommonStatesJob, CommonStatesSettings, ScoredMethodSettings
from avs.nvs.episode_settings import EpisodeSettings
from avs.nvs.protocol import OWN_SETTINGS
from avs.nvs.timing_settings import RuntimeSettings, StateSettings, TimingSettings
from avs.report.published import COVERAGE_NAME, PICTURES, RUNTIME_NAMES
from avs.representations.needed_points import NeededPoints
from avs.scene.images import BLACK
from avs.sfm.back_end_registry import why_not
from avs.system.models import StrictModel
from avs.system.reasons import Reason


class SceneJob(StrictModel):
    """What the preparation of a scene reads."""

    dataset: str = Field(description="name of the data set")
    scene: DataSet = Field(description="settings of the scene alone")
    points: NeededPoints | None = Field(default=None, description="what the reconstruction needs of its points")


def _scene(config: Config, name: str) -> SceneJob:
    dataset, scene = name.split("/")
    alone = scenes_in(config.datasets[dataset])[scene]
    background = getattr(config.representation, "background", BLACK)
    # What tables make of the scene does not change it.
    settings = alone.model_copy(update={"published": None, "methods": None, "tables": None}).on_background(background)
    return SceneJob(dataset=dataset, scene=settings, points=config.representation.needed_points())


def _episode(config: Config, method: str) -> EpisodeSettings:
    protocol = protocol_of(config, method)
    return EpisodeSettings(
        method=method,
        device=config.device,
        protocol=protocol,
        own=tuple(name for name in OWN_SETTINGS if getattr(protocol, name) != getattr(config.protocol, name)),
        representation=config.representation,
        selector=config.selectors.get(method, {}),
        pictures=config.pictures,
    )


def _common_states(config: Config, dataset: str) -> CommonStatesJob:
    return CommonStatesJob(
        device=config.device,
        protocol=config.protocol,
        representation=config.representation,
        common_states=config.common_states or CommonStatesSettings(),
        methods=tuple(
            ScoredMethodSettings(
                method=method,
                selector=config.selectors.get(method, {}),
                views_together=protocol_of(config, method).views_together,
            )
            for method in scoring_methods(config, dataset)
        ),
    )


def _runtime_state(config: Config, _: str) -> StateSettings:
    return StateSettings(
        device=config.device,
        protocol=config.protocol,
        representation=config.representation,
        runtime=config.runtime or RuntimeSettings(),
    )


def _runtime(config: Config, method: str) -> TimingSettings:
    return TimingSettings(
        **dict(_runtime_state(config, "")),
        method=method,
        selector=config.selectors.get(method, {}),
        views_per_step=protocol_of(config, method).views_together,
    )


def _runtime_table(config: Config, _: str) -> RowsJob:
    dataset, scene = timed_scene(config)
    return RowsJob(**rows_of(config, dataset, that_choose=True) | {"scenes": {dataset: (scene,)}})


def _nvs_table(config: Config, dataset: str) -> TableJob:
    reader = config.datasets[dataset]
    pictures = reader.model_dump(include=set(PICTURES)) if isinstance(reader, FolderReader) else {}
    return TableJob(
        **dict(_significance_table(config, dataset)),
        published=published_means(config, dataset),
        reference=config.report.reference,
        pictures=pictures,
    )


def _side_by_side_table(config: Config, _: str) -> SideBySideJob:
    told = (dict(_nvs_table(config, name)) | {"dataset": name} for name in side_by_side(config))
    return SideBySideJob(data_sets=tuple(NamedTableJob(**each) for each in told))


def _scene_table(config: Config, dataset: str) -> SceneTableJob:
    return SceneTableJob(**dict(_significance_table(config, dataset)), published=published_scenes(config, dataset))


def _runtime_summary(config: Config, summary: str) -> SummaryJob:
    told = dict(_runtime_table(config, ""))
    if summary == "memory":
        told["methods"] = with_memory(config, timed_scene(config)[0])
    return SummaryJob(**told, published=f"{FOLDER}/{RUNTIME_NAMES[summary]}")


def _significance_table(config: Config, dataset: str) -> DataSetJob:
    return DataSetJob(**rows_of(config, dataset), left_out=dict(config.datasets[dataset].left_out()))


def _critical_difference(config: Config, dataset: str) -> FigureJob:
    return FigureJob(**records_of(config, dataset))


def _ranking_table(config: Config, dataset: str) -> RowsJob:
    return RowsJob(**rows_of(config, dataset, that_choose=True))


def _sensitivity_episode(config: Config, name: str) -> EpisodeSettings:
    variant, method = name.split("/")
    return _episode(variant_of(config, variant).model_copy(update={"pictures": None}), method)


def _sensitivity_table(config: Config, dataset: str) -> SensitivityJob:
    variants = () if config.sensitivity is None else tuple(config.sensitivity.variants)
    return SensitivityJob(**rows_of(config, dataset) | {"methods": studied_methods(config, dataset)}, variants=variants)


def _agnostic_episode(config: Config, name: str) -> EpisodeSettings:
    representation, method = name.split("/")
    return _episode(on_representation(config, representation).model_copy(update={"pictures": None}), method)


def _figure(config: Config, _: str) -> FigureJob:
    return FigureJob(**records_of(config))


def _drawn(config: Config, dataset: str) -> DrawnJob:
    """Return what a figure of one data set reads, or one of all."""
    records = records_of(config, *([dataset] if dataset else []))
    return DrawnJob(**records, figures=config.report.figures, reference=config.report.reference)


def _timed_drawn(config: Config, _: str) -> DrawnJob:
    """Return what a figure of the scene reads on which selections are timed."""
    return _drawn(config, timed_scene(config)[0])


def _coverage_reference(config: Config, _: str) -> ReferenceJob:
    told = config.coverage or CoverageSettings()
    values = {name: getattr(told, name) for name in ReferenceJob.model_fields if name != "device"}
    return ReferenceJob(device=config.device, **values)


def _coverage(config: Config, _: str) -> CoverageJob:
    told = config.coverage or CoverageSettings()
    values = {name: getattr(told, name) for name in CoverageJob.model_fields if name != "device"}
    return CoverageJob(device=config.device, **values)


def _coverage_table(config: Config, dataset: str) -> CoverageTableJob:
    # The paper has coverage on RealEstate10K alone; beside captures that stand for no data set of it, it says nothing.
    beside = published_means(config, dataset) is not None
    return CoverageTableJob(
        **rows_of(config, dataset),
        published=f"{FOLDER}/{COVERAGE_NAME}" if beside else None,
        reference=config.report.reference,
        lacking=coverage_lacking(config),
    )


def coverage_lacking(config: Config) -> Reason | None:
    """Return why coverage cannot be measured here, or None if it can."""
    return why_not((config.coverage or CoverageSettings()).sfm)


JOBS: dict[str, Callable[[Config, str], StrictModel]] = {
    "scene": _scene,
    **SCORER_JOBS,
    "episode": _episode,
    "common_states": _common_states,
    "runtime_state": _runtime_state,
    "runtime": _runtime,
    "runtime_table": _runtime_table,
    "runtime_summary": _runtime_summary,
    "nvs_table": _nvs_table,
    "scene_table": _scene_table,
    "side_by_side_table": _side_by_side_table,
    "significance_table": _significance_table,
    "critical_difference": _critical_difference,
    "ranking_table": _ranking_table,
    "sensitivity_episode": _sensitivity_episode,
    "sensitivity_table": _sensitivity_table,
    "agnostic_episode": _agnostic_episode,
    "agnostic_table": agnostic_table,
    "psnr_over_views": _drawn,
    "coverage_reference": _coverage_reference,
    "coverage": _coverage,
    "coverage_table": _coverage_table,
    "coverage_maps": _figure,
    "coverage_over_views": _drawn,
    "qualitative": _drawn,
    "selected_cameras": _drawn,
    "score_maps": _drawn,
    "teaser": _timed_drawn,
    "time_and_psnr": _timed_drawn,
    **SLAM_JOBS,
    **PAGE_JOBS,
}
"""What makes the settings of a rule's jobs: from the configuration and the name of a method, scene, data set or scorer,
those of a variant or representation and a method, or which of two tables. Where all jobs of a rule read the same, that
name is empty."""


def settings_of(config: Config, job: str) -> StrictModel:
    """Return the settings of a job, given as ``rule`` or ``rule/name``, such as ``episode/random``."""
    rule, _, name = job.partition("/")
    return JOBS[rule](config, name)
