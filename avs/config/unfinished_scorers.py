"""What the table of scorers is made from, whether it is there or not."""

from __future__ import annotations

from pathlib import Path

from avs.config.held_out_jobs import scorer_table_job
from avs.config.run_plan import RunPlan
from avs.report.incomplete_scorers import WantedHeldOut, WantedScorers
from avs.system.ledger import why_left_out


def wanted_scorers(plan: RunPlan) -> WantedScorers | None:
    """Return what the table is made from, or None where the run makes none."""
    told = scorer_table_job(plan.config)
    if not told.scenes:
        return None
    places = [{"dataset": dataset, "scene": scene} for dataset, scenes in told.scenes.items() for scene in scenes]
    rules = ("held_out_scores", "distortions", "scene", "kernels")
    records = []
    for place in places:
        logs = tuple(Path(plan.logs[rule].format(**place)) for rule in rules)
        path = Path(plan.records["held_out_scores"].format(**place))
        records.append(WantedHeldOut(path, logs, why_left_out(logs, plan.stamps)))
    return WantedScorers(tuple(records), told.scenes, told.methods, told.absent)
