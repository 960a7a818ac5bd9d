"""The jobs of a run that has been planned: what each was to write, and why that is not there or does not count."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from avs.config.jobs import settings_of
from avs.config.run_plan import RunPlan
from avs.system.files import canonical_json
from avs.system.models import StrictModel
from avs.system.stale_jobs import linked, stale_jobs, why_left_out

Place = Mapping[str, object]
"""Values of the wildcards of a path."""

_Settings = TypeVar("_Settings", bound=StrictModel)


@dataclass(frozen=True)
class PlannedJob:
    """One job.

    Attributes:
        path: of the record that it writes.
        logs: its own, then those of all jobs that it waits for, directly or not, the nearest first.
        stale: why the record does not count though it is there, or None.
    """

    path: Path
    logs: tuple[Path, ...]
    stale: str | None


@dataclass(frozen=True)
class PlannedJobs:
    """All of them.

    Attributes:
        plan: of the run.
        stale: why what a job wrote does not count, by its log; see ``avs.system.stale_jobs.stale_jobs``.
    """

    plan: RunPlan
    stale: Mapping[str, str]

    def job(self, rule: str, place: Place) -> PlannedJob:
        """Return the job of a rule of the plan."""
        log = self.plan.logs[rule].format(**place)
        return PlannedJob(
            path=self.record(rule, place),
            logs=tuple(map(Path, (log, *linked([log], self.plan.waits_for)))),
            stale=why_left_out(Path(log), self.plan.stamps, self.stale),
        )

    def record(self, rule: str, place: Place) -> Path:
        """Return the path of the record that the job of a rule writes."""
        return Path(self.plan.records[rule].format(**place))

    def settings(self, job: str, kind: type[_Settings]) -> _Settings:
        """Return the settings of a job as it reads them.

        The keys of their file are sorted, and so may be what is tabulated in the order of their entries.
        """
        told = settings_of(self.plan.config, job).model_dump_json()
        return kind.model_validate_json(canonical_json(json.loads(told)))


def planned_jobs(plan: RunPlan) -> PlannedJobs:
    """Return the jobs of a run, looked at once."""
    return PlannedJobs(plan, stale_jobs(plan.stamps, plan.waits_for, plan.settings))
