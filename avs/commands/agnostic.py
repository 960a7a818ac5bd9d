"""The command that tabulates the same methods on several representations."""

from __future__ import annotations

from typing import Annotated

import typer

from avs.commands.arguments import Log, SettingsFile, Stem, files_by_name
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()


@commands.command("agnostic_table")
def agnostic_table(
    dataset: Annotated[str, typer.Option(help="data set whose records these are")],
    settings: SettingsFile,
    out: Stem,
    episode: Annotated[list[str] | None, typer.Option(help="REPRESENTATION=FILE, an episode on it")] = None,
    log: Log = None,
) -> None:
    """Write each method's metrics and rank on several representations, and how the orders agree."""
    with job(log):
        from avs.config.report_jobs import AgnosticJob
        from avs.report.tables.representation_agreement import write_agnostic_table

        told = read_settings(settings, AgnosticJob)
        files = files_by_name(episode, told.representations)
        write_agnostic_table(files, told.methods, dataset, out, told.absent)
