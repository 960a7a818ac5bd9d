"""The command that tabulates how far the order of methods depends on the settings."""

from __future__ import annotations

from typing import Annotated

import typer

from avs.commands.arguments import Episodes, Log, SettingsFile, Stem, files_by_name
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()


@commands.command("sensitivity_table")
def sensitivity_table(
    episodes: Episodes,
    dataset: Annotated[str, typer.Option(help="data set whose records these are")],
    settings: SettingsFile,
    out: Stem,
    varied: Annotated[
        list[str] | None, typer.Option(help="VARIANT=FILE, an episode under a variant of the settings")
    ] = None,
    log: Log = None,
) -> None:
    """Write each method's PSNR and rank under variants of the settings, and how the orders agree."""
    with job(log):
        from avs.config.report_jobs import SensitivityJob
        from avs.report.tables.setting_sensitivity import write_sensitivity_table

        told = read_settings(settings, SensitivityJob)
        files = files_by_name(varied, told.variants)
        write_sensitivity_table(episodes, files, told.methods, dataset, out, told.absent)
