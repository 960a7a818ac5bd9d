"""The command that makes scenes."""

from __future__ import annotations

import typer

from avs.commands.arguments import Log, Out, SettingsFile
from avs.system.job_process import job
from avs.system.records import read_record

commands = typer.Typer()


@commands.command()
def scene(settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Prepare a scene, as the reader of its data set does."""
    from avs.config.jobs import SceneJob

    with job(log):
        told = read_record(settings, SceneJob)
        told.scene.prepare(told.dataset, out)
