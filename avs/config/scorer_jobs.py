"""What the jobs read that train scorers, fit what has parameters, and measure both on held-out scenes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from pydantic import Field

from avs.config.configuration import scorer_of
from avs.config.held_out_jobs import held_out_job, regression_settings, scorer_table_job
from avs.config.other_representations import representation_of
from avs.config.run_config import Config
from avs.iqa.cross_reference.scorer_settings import RenderJob, RenderSettings, ScorerSettings
from avs.iqa.no_reference.niqe_settings import FitSettings
from avs.selection import registry
from avs.system.models import StrictModel


class TrainingJob(StrictModel):
    """What the training of a scorer reads."""

    device: Literal["cpu", "cuda"] = Field(description="where networks run")
    scorer: ScorerSettings = Field(description="the scorer")


def _distortions(config: Config, dataset: str) -> RenderJob:
    """Return what the renderings of a data set read; an empty name is any that has the run's reconstruction."""
    renders = RenderSettings() if config.distortions is None else config.distortions.renders
    return RenderJob(device=config.device, representation=representation_of(config, dataset), renders=renders)


def _scorer_train(config: Config, scorer: str) -> TrainingJob:
    return TrainingJob(device=config.device, scorer=scorer_of(config, scorer))


def _niqe_fit(config: Config, _: str) -> FitSettings:
    return FitSettings.taken_from(registry.create_settings("niqe", config.selectors.get("niqe", {})))


SCORER_JOBS: dict[str, Callable[[Config, str], StrictModel]] = {
    "distortions": _distortions,
    "scorer_train": _scorer_train,
    "niqe_fit": _niqe_fit,
    "statistics_fit": lambda config, _: regression_settings(config),
    "held_out_scores": lambda config, _: held_out_job(config),
    "scorer_table": lambda config, _: scorer_table_job(config),
}
"""A part of ``avs.config.jobs.JOBS``."""
