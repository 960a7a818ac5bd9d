"""The episodes that a run is made of, among all that lie in the folder of its results."""

from __future__ import annotations

from pathlib import Path

from avs.config.method_weights import absent_methods
from avs.config.run_plan import PLAN_NAME, RunPlan
from avs.system.records import read_record


def episodes_of_run(results: Path) -> list[Path]:
    """Return the records of the episodes that the last run in a folder asks for and that are there, sorted.

    Others may lie beside them, of seeds and methods that an earlier run had. Where no plan tells, all count.

    Args:
        results: folder of the results, wherever it has been moved to.

    Raises:
        UserError: the plan is damaged.
    """
    written = results / PLAN_NAME
    if not written.is_file():
        return sorted(results.glob("episodes/*/*/*/*/episode.json"))
    plan = read_record(written, RunPlan, "begin the run again, which writes it")
    config = plan.config.planned_with(plan.weights_at_hand, plan.programs)
    absent = absent_methods(config)
    places = (
        {"dataset": dataset, "scene": scene, "method": method, "seed": seed}
        for dataset in config.evaluated
        for scene in plan.scenes[dataset]
        for method in config.methods_on(dataset)
        if method not in absent
        for seed in config.seeds
    )
    planned = (Path(plan.records["episode"].format(**place)).relative_to(plan.results) for place in places)
    return sorted(path for path in (results / each for each in planned) if path.is_file())
