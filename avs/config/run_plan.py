"""What a run asks for: which records of which scenes, where they are, and where their jobs tell of faults.

The workflow writes it before the first job, so that a run can be tabulated that has not come to its end.
"""

from __future__ import annotations

from pathlib import Path

from pydantic import Field

from avs.config.run_config import Config
from avs.system.errors import UserError
from avs.system.models import StrictModel
from avs.system.records import read_record

PLAN_NAME = "plan.json"
"""Name of the file in the folder of the results."""


class RunPlan(StrictModel):
    """A run. Paths are relative to the folder that Snakemake runs in; names of wildcards are in braces."""

    config: Config = Field(description="the checked configuration")
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


def read_plan(results: Path) -> RunPlan:
    """Read the plan of the run whose results lie in a folder.

    Raises:
        UserError: there is none, or it is damaged.
    """
    written = results / PLAN_NAME
    if not written.exists():
        raise UserError(written, "is not there", "name the results of a run that has begun, such as results/ci")
    return read_record(written, RunPlan, "begin the run again, which writes it")
