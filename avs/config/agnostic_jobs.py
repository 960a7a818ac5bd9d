"""What the jobs of the table `agnostic` read of the configuration."""

from __future__ import annotations

from avs.config.method_weights import absent_methods
from avs.config.other_representations import agnostic_methods, agnostic_seeds, on_representation
from avs.config.report_jobs import AgnosticJob
from avs.config.run_config import Config
from avs.config.scenes import scenes_in
from avs.system.reasons import Reason


def agnostic_absent(config: Config) -> dict[str, dict[str, Reason]]:
    """Return why a method of that table does not run on a representation, by representation and method."""
    names = () if config.agnostic is None else tuple(config.agnostic.representations)
    methods = agnostic_methods(config)
    found = {name: absent_methods(on_representation(config, name)) for name in names}
    return {name: {method: each[method] for method in methods if method in each} for name, each in found.items()}


def agnostic_table(config: Config, dataset: str) -> AgnosticJob:
    """Return what the table of a data set reads."""
    return AgnosticJob(
        methods=agnostic_methods(config),
        scenes={dataset: tuple(scenes_in(config.datasets[dataset]))},
        seeds=agnostic_seeds(config),
        representations=() if config.agnostic is None else tuple(config.agnostic.representations),
        absent=agnostic_absent(config),
    )
