"""Commands that fit the parameters of no-reference metrics."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from avs.commands.arguments import Log, Out
from avs.system.compatibility import prepare_torch
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()


@commands.command("niqe_fit")
def niqe_fit(
    scenes: Annotated[list[Path], typer.Argument(help="folders of scenes, none of which is evaluated")],
    out: Out,
    settings: Annotated[Path | None, typer.Option(help="settings, a JSON file written by the workflow")] = None,
    log: Log = None,
) -> None:
    """Fit NIQE's parameters on photographs, where the published ones are absent."""
    with job(log) as console:
        from avs.iqa.no_reference.niqe_fit import fit_scenes
        from avs.iqa.no_reference.niqe_settings import FitSettings

        prepare_torch()
        checked = FitSettings() if settings is None else read_settings(settings, FitSettings)
        fit_scenes(scenes, checked, out, console.progress)
