"""What the table of scorers is made from, whether it is there or not."""

from __future__ import annotations

from avs.config.planned_jobs import PlannedJobs
from avs.config.report_jobs import ScorerTableJob
from avs.report.incomplete_scorers import WantedHeldOut, WantedScorers


def wanted_scorers(jobs: PlannedJobs) -> WantedScorers | None:
    """Return what the table is made from, or None where the run makes none."""
    told = jobs.settings("scorer_table", ScorerTableJob)
    if not told.scenes:
        return None
    places = [{"dataset": dataset, "scene": scene} for dataset, scenes in told.scenes.items() for scene in scenes]
    found = [jobs.job("held_out_scores", place) for place in places]
    records = tuple(WantedHeldOut(each.path, each.logs, each.stale) for each in found)
    return WantedScorers(records, told.scenes, told.methods, told.absent, told.same_pictures)
