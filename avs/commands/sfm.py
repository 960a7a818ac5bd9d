"""Commands that measure the coverage of episodes' views in structure from motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from avs.commands.arguments import Episodes, Log, Out, SceneFolder, SettingsFile, Stem
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()

Records = Annotated[list[Path] | None, typer.Option(help="coverage.json of an episode")]


@commands.command("stereo_kernels")
def stereo_kernels(log: Log = None) -> None:
    """Compile the kernels of dense stereo, so that no job of coverage has to."""
    with job(log):
        from avs.sfm.stereo_compilation import compile_stereo

        compile_stereo()


@commands.command("coverage_reference")
def coverage_reference(scene: SceneFolder, settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Make the cloud of all views of a scene, against which the clouds of its episodes are held."""
    with job(log):
        from avs.coverage.coverage_settings import ReferenceJob
        from avs.coverage.reference_cloud import write_reference

        write_reference(scene, read_settings(settings, ReferenceJob), out)


@commands.command()
def coverage(
    scene: SceneFolder,
    episode: Annotated[Path, typer.Argument(help="its record, episode.json")],
    reference: Annotated[Path, typer.Option(help="folder of the scene's reference, from coverage_reference")],
    settings: SettingsFile,
    out: Out,
    log: Log = None,
) -> None:
    """Measure how much of the scene the views of an episode cover."""
    with job(log) as console:
        from avs.coverage.coverage_settings import CoverageJob
        from avs.coverage.episode_coverage import write_coverage

        write_coverage(scene, episode, reference, read_settings(settings, CoverageJob), out, console.progress)


@commands.command("coverage_table")
def coverage_table(
    episodes: Episodes,
    dataset: Annotated[str, typer.Option(help="data set whose records these are")],
    settings: SettingsFile,
    out: Stem,
    coverage: Records = None,
    log: Log = None,
) -> None:
    """Write the coverage table of a data set as csv, md and tex."""
    with job(log):
        from avs.config.report_jobs import CoverageTableJob
        from avs.report.tables.scene_coverage import write_coverage_table

        told = read_settings(settings, CoverageTableJob)
        published = None if told.published is None else Path(told.published)
        arguments = (told.methods, dataset, published, out, told.absent, told.lacking, told.reference)
        write_coverage_table(episodes, coverage or [], *arguments)


@commands.command("coverage_maps")
def coverage_maps(
    scene: SceneFolder,
    records: Annotated[list[Path], typer.Argument(help="coverage.json of each method, with one seed")],
    settings: SettingsFile,
    out: Stem,
    covered: Annotated[list[Path] | None, typer.Option(help="covered.ply of each of them, in the same order")] = None,
    log: Log = None,
) -> None:
    """Draw where the views of each method leave the reference of a scene uncovered."""
    with job(log):
        from avs.config.report_jobs import FigureJob
        from avs.report.figures.coverage_maps import write_coverage_maps

        write_coverage_maps(scene, records, covered or [], read_settings(settings, FigureJob).methods, out)


@commands.command("coverage_over_views")
def coverage_over_views(
    episodes: Episodes, settings: SettingsFile, out: Stem, coverage: Records = None, log: Log = None
) -> None:
    """Draw the surface coverage ratio over the number of captured views."""
    with job(log):
        from avs.config.report_jobs import DrawnJob
        from avs.report.figures.coverage_over_views import write_coverage_over_views

        told = read_settings(settings, DrawnJob)
        write_coverage_over_views(episodes, coverage or [], told.methods, out, told.reference)
