"""Commands that draw figures from records and what lies beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from avs.commands.arguments import Episodes, Log, SceneFolder, SettingsFile, Stem
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()

Dataset = Annotated[str, typer.Option(help="data set whose records these are")]
Scenes = Annotated[list[Path] | None, typer.Option(help="folder of a scene that is shown; once for each")]


@commands.command("psnr_over_views")
def psnr_over_views(episodes: Episodes, settings: SettingsFile, out: Stem, log: Log = None) -> None:
    """Draw the test PSNR over the number of captured views."""
    with job(log):
        from avs.config.report_jobs import DrawnJob
        from avs.report.figures.psnr_over_views import write_psnr_over_views

        told = read_settings(settings, DrawnJob)
        write_psnr_over_views(episodes, told.methods, out, told.reference)


@commands.command()
def qualitative(episodes: Episodes, settings: SettingsFile, out: Stem, scene: Scenes = None, log: Log = None) -> None:
    """Draw renderings of several methods beside the photographs."""
    with job(log):
        from avs.config.report_jobs import DrawnJob
        from avs.report.figures.qualitative import write_qualitative

        told = read_settings(settings, DrawnJob)
        write_qualitative(episodes, scene or [], told.methods, told.figures, told.reference, out)


@commands.command("selected_cameras")
def selected_cameras(
    scene: SceneFolder, episodes: Episodes, dataset: Dataset, settings: SettingsFile, out: Stem, log: Log = None
) -> None:
    """Draw which views each method selected on a scene, in which order."""
    with job(log):
        from avs.config.report_jobs import DrawnJob
        from avs.report.figures.selected_cameras import write_selected_cameras

        write_selected_cameras(episodes, scene, read_settings(settings, DrawnJob).methods, dataset, out)


@commands.command("score_maps")
def score_maps(
    episodes: Episodes,
    dataset: Dataset,
    scene: Annotated[str, typer.Option(help="name of the scene that is shown")],
    settings: SettingsFile,
    out: Stem,
    log: Log = None,
) -> None:
    """Draw the maps by which methods chose views beside the true ones."""
    with job(log):
        from avs.config.report_jobs import DrawnJob
        from avs.report.figures.score_maps import write_score_maps

        told = read_settings(settings, DrawnJob)
        write_score_maps(episodes, told.methods, told.figures.moments, dataset, scene, out)


@commands.command()
def teaser(
    records: Annotated[list[Path], typer.Argument(help="records of the timing, one a method")],
    settings: SettingsFile,
    out: Stem,
    episode: Annotated[list[Path] | None, typer.Option(help="an episode on the scene of the timing")] = None,
    log: Log = None,
) -> None:
    """Draw selection time against test PSNR."""
    with job(log):
        from avs.config.report_jobs import DrawnJob
        from avs.report.figures.teaser import write_teaser

        write_teaser(records, episode or [], read_settings(settings, DrawnJob).methods, out)


@commands.command("time_and_psnr")
def time_and_psnr(episodes: Episodes, dataset: Dataset, settings: SettingsFile, out: Stem, log: Log = None) -> None:
    """Draw the time of each selection and the test PSNR over the number of captured views."""
    with job(log):
        from avs.config.report_jobs import DrawnJob
        from avs.report.figures.time_and_psnr import write_time_and_psnr

        told = read_settings(settings, DrawnJob)
        write_time_and_psnr(episodes, told.methods, dataset, told.reference, out)


@commands.command("egocentric_and_phone")
def egocentric_and_phone(
    egocentric: SceneFolder,
    phone: Annotated[Path, typer.Argument(help="folder of a scene that a phone captured")],
    out: Stem,
    log: Log = None,
) -> None:
    """Draw egocentric photographs beside those of a phone."""
    with job(log):
        from avs.report.figures.egocentric_and_phone import write_egocentric_and_phone

        write_egocentric_and_phone(egocentric, phone, out)
