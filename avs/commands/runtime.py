"""Commands that time the selections of each method."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from avs.commands.arguments import Log, Out, SceneFolder, SettingsFile, Weights
from avs.system.compatibility import prepare_torch
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()


@commands.command("runtime_state")
def runtime_state(scene: SceneFolder, settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Fit the reconstruction that methods are timed on."""
    with job(log):
        from avs.nvs.timing import write_state
        from avs.nvs.timing_settings import StateSettings

        prepare_torch()
        write_state(scene, read_settings(settings, StateSettings), out)


@commands.command()
def runtime(
    scene: SceneFolder,
    state: Annotated[Path, typer.Option(help="checkpoint of the reconstruction")],
    settings: SettingsFile,
    out: Out,
    weights: Weights = None,
    log: Log = None,
) -> None:
    """Time the selections of one method; nothing else should run meanwhile."""
    with job(log) as console:
        from avs.nvs.timing import time_method
        from avs.nvs.timing_settings import TimingSettings

        prepare_torch()
        checked = read_settings(settings, TimingSettings)
        time_method(scene, state, checked, weights, out, console.progress)
