"""What the tables of several representations are made from, whether it is there or not."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from avs.config.other_representations import agnostic_datasets
from avs.config.planned_jobs import Place, PlannedJobs
from avs.config.report_jobs import AgnosticJob
from avs.report.wanted_records import WantedAgnostic, WantedEpisode


def wanted_agnostic(jobs: PlannedJobs, episode: Callable[[Place], WantedEpisode]) -> Iterator[WantedAgnostic]:
    """Yield the tables that the run makes with the others, and those that have been begun.

    Args:
        jobs: of the run.
        episode: makes what is to be known of the record of an episode on a representation.
    """
    told = jobs.plan.config.agnostic
    if told is None:
        return
    for dataset in agnostic_datasets(jobs.plan.config):
        settings = jobs.settings(f"agnostic_table/{dataset}", AgnosticJob)
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
                for method in settings.methods
                if method not in settings.absent[name]
                for scene in jobs.plan.scenes[dataset]
                for seed in settings.seeds
            )
            for name in settings.representations
        }
        if told.with_tables or any(each.path.exists() for episodes in found.values() for each in episodes):
            yield WantedAgnostic(dataset, settings.methods, found, settings.absent)
