"""What a run asks for: which records of which scenes, where they are, and where their jobs tell of faults.

The workflow writes it before the first job, so that a run can be tabulated that has not come to its end.
"""

from __future__ import annotations

from pathlib import Path

from pydantic import Field, ValidationInfo, field_serializer, field_validator

from avs.config.run_config import Config
from avs.system.errors import UserError
from avs.system.models import StrictModel
from avs.system.records import read_record

PLAN_NAME = "plan.json"
"""Name of the file in the folder of the results."""


class RunPlan(StrictModel):
    """A run. Paths are relative to the folder that Snakemake runs in; names of wildcards are in braces."""

    results: str = Field(description="the folder of the results")
    config: Config = Field(
        description="the checked configuration, as JSON in a text, where its entries keep their order"
    )
    weights_at_hand: tuple[str, ...] = Field(
        default=(), description="methods that needed no weights, had theirs, or had them made by the run"
    )
    programs: tuple[str, ...] | None = Field(
        default=None, description="methods that are programs of their own; null: not known"
    )
    scenes: dict[str, tuple[str, ...]] = Field(description="scenes of each data set, those for scorers included")
    timed: tuple[str, str] | None = Field(description="data set and scene on which selections are timed, or null")
    studied: dict[str, tuple[str, ...]] = Field(
        default_factory=dict, description="scenes of each data set on which methods run under variants of the settings"
    )
    published_times: tuple[str, ...] = Field(description="files of the paper's times")
    records: dict[str, str] = Field(description="path of the record that a rule writes, by rule")
    logs: dict[str, str] = Field(description="path of a job's log, by rule")
    stamps: dict[str, str] = Field(
        default_factory=dict,
        description="what each job is told of the files that it reads and no job makes, by its log",
    )
    waits_for: dict[str, tuple[str, ...]] = Field(
        default_factory=dict, description="logs of the jobs that make what a job reads, by its log"
    )
    settings: dict[str, str] = Field(
        default_factory=dict, description="SHA-256 of what each file of settings is to hold, by its path"
    )

    @field_serializer("config")
    def _as_text(self, config: Config) -> str:
        # A record's keys are sorted, and the order of data sets, methods and the like is that of tables' rows.
        return config.model_dump_json()

    @field_validator("config", mode="before")
    @classmethod
    def _from_text(cls, config: object) -> object:
        return Config.model_validate_json(config) if isinstance(config, str) else config

    @field_validator("scenes", "studied")
    @classmethod
    def _as_configured(cls, scenes: dict[str, tuple[str, ...]], told: ValidationInfo) -> dict[str, tuple[str, ...]]:
        if "config" not in told.data:  # it has a fault, which is told
            return scenes
        order = list(told.data["config"].datasets)
        return {name: scenes[name] for name in sorted(scenes, key=lambda name: order.index(name))}


def read_plan(results: Path) -> RunPlan:
    """Read the plan of the run whose results lie in a folder.

    Raises:
        UserError: there is none, it is damaged, or the run's records are in another folder.
    """
    written = results / PLAN_NAME
    if not written.exists():
        raise UserError(written, "is not there", "name the results of a run that has begun, such as results/ci")
    plan = read_record(written, RunPlan, "begin the run again, which writes it")
    if results.resolve() != Path(plan.results).resolve():
        fault = f"is of a run whose results are in {plan.results}, below the folder of the workflow"
        raise UserError(written, fault, f"run this where {results} is that folder, or give it back that name")
    return plan.model_copy(update={"config": plan.config.planned_with(plan.weights_at_hand, plan.programs)})
