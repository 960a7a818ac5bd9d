"""What the tables of several representations are made from, whether it is there or not."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from avs.config.agnostic_jobs import agnostic_absent
from avs.config.other_representations import agnostic_datasets, agnostic_methods, agnostic_seeds
from avs.config.run_plan import RunPlan
from avs.report.wanted_records import WantedAgnostic, WantedEpisode

Place = dict[str, str]
"""Values of the wildcards of a path."""


def wanted_agnostic(plan: RunPlan, episode: Callable[[Place], WantedEpisode]) -> Iterator[WantedAgnostic]:
    """Yield the tables that the run makes with the others, and those that have been begun.

    Args:
        plan: of the run.
        episode: makes what is to be known of the record of an episode on a representation.
    """
    told = plan.config.agnostic
    if told is None:
        return
    absent, methods = agnostic_absent(plan.config), agnostic_methods(plan.config)
    for dataset in agnostic_datasets(plan.config):
        found = {
            name: tuple(
                episode(
                    {
                        "representation": name,
                        "method": method,
                        "dataset": dataset,
                        "scene": scene,
                        "seed": str(seed),
                    }
                )
                for method in methods
                if method not in absent[name]
                for scene in plan.scenes[dataset]
                for seed in agnostic_seeds(plan.config)
            )
            for name in told.representations
        }
        if told.with_tables or any(each.path.exists() for episodes in found.values() for each in episodes):
            yield WantedAgnostic(dataset, methods, found, absent)
