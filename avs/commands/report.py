"""Commands that write tables and figures from records."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from avs.commands.arguments import Episodes, Log, SettingsFile, Stem
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()

States = Annotated[list[Path], typer.Argument(help="records of the common states, one a scene and seed")]
Dataset = Annotated[str, typer.Option(help="data set whose records these are")]


@commands.command("nvs_table")
def nvs_table(episodes: Episodes, dataset: Dataset, settings: SettingsFile, out: Stem, log: Log = None) -> None:
    """Write the view selection table of a data set as csv, md and tex."""
    with job(log):
        from avs.config.report_jobs import TableJob
        from avs.report.tables.view_synthesis import write_nvs_table

        told = read_settings(settings, TableJob)
        published = None if told.published is None else Path(told.published)
        beside = (told.absent, told.reference, told.left_out, told.pictures)
        write_nvs_table(episodes, told.methods, dataset, published, out, *beside)


@commands.command("scene_table")
def scene_table(episodes: Episodes, dataset: Dataset, settings: SettingsFile, out: Stem, log: Log = None) -> None:
    """Write the view selection table of the single scenes of a data set as csv, md and tex."""
    with job(log):
        from avs.config.report_jobs import SceneTableJob
        from avs.report.tables.scene_by_scene import write_scene_table

        told = read_settings(settings, SceneTableJob)
        published = list(map(Path, told.published))
        write_scene_table(episodes, told.methods, dataset, published, out, told.absent, told.left_out)


@commands.command("significance_table")
def significance_table(
    episodes: Episodes, dataset: Dataset, settings: SettingsFile, out: Stem, log: Log = None
) -> None:
    """Write which methods of a data set differ, as csv, md and tex."""
    with job(log):
        from avs.config.report_jobs import DataSetJob
        from avs.report.tables.method_significance import write_significance_table

        told = read_settings(settings, DataSetJob)
        write_significance_table(episodes, told.methods, dataset, out, told.absent, told.left_out)


@commands.command("critical_difference")
def critical_difference(
    episodes: Episodes, dataset: Dataset, settings: SettingsFile, out: Stem, log: Log = None
) -> None:
    """Draw the average ranks of the methods of a data set with their critical difference."""
    with job(log):
        from avs.config.report_jobs import FigureJob
        from avs.report.figures.critical_difference import write_critical_difference

        write_critical_difference(episodes, read_settings(settings, FigureJob).methods, dataset, out)


@commands.command("side_by_side_table")
def side_by_side_table(episodes: Episodes, settings: SettingsFile, out: Stem, log: Log = None) -> None:
    """Write the view selection table of several data sets as csv, md and tex."""
    with job(log):
        from avs.config.report_jobs import SideBySideJob
        from avs.report.collect import read_episodes
        from avs.report.tables.data_sets_side_by_side import ShownDataSet, write_side_by_side_table

        told = read_settings(settings, SideBySideJob).data_sets
        methods = [method for each in told for method in each.methods]
        found = {each.dataset: each for each in read_episodes(episodes, methods)}
        sets = [
            ShownDataSet(
                found[each.dataset],
                each.methods,
                each.absent,
                None if each.published is None else Path(each.published),
                each.pictures,
                each.left_out,
            )
            for each in told
        ]
        write_side_by_side_table(sets, out)


@commands.command("scorer_table")
def scorer_table(
    records: Annotated[list[Path], typer.Argument(help="scores of the renderings of held-out scenes, one a scene")],
    settings: SettingsFile,
    out: Stem,
    log: Log = None,
) -> None:
    """Write how well scorers predict SSIM on held-out scenes, as csv, md and tex."""
    with job(log):
        from avs.config.report_jobs import ScorerTableJob
        from avs.report.tables.scorer_agreement import write_scorer_table

        told = read_settings(settings, ScorerTableJob)
        write_scorer_table(records, told.scenes, told.methods, out, told.absent, told.same_pictures)


@commands.command("ranking_table")
def ranking_table(records: States, dataset: Dataset, settings: SettingsFile, out: Stem, log: Log = None) -> None:
    """Write how well each method's scores rank the candidates of a data set, as csv, md and tex."""
    with job(log):
        from avs.config.report_jobs import RowsJob
        from avs.report.tables.score_ranking import write_ranking_table

        told = read_settings(settings, RowsJob)
        write_ranking_table(records, told.methods, dataset, out, told.absent)


@commands.command("runtime_table")
def runtime_table(
    records: Annotated[list[Path], typer.Argument(help="records of the timing, one a method")],
    settings: SettingsFile,
    out: Stem,
    episode: Annotated[list[Path] | None, typer.Option(help="an episode on the scene, for the PSNR")] = None,
    published: Annotated[list[Path] | None, typer.Option(help="a file of results/published")] = None,
    log: Log = None,
) -> None:
    """Write the table of selection times as csv, md and tex."""
    with job(log):
        from avs.config.report_jobs import RowsJob
        from avs.report.tables.selection_times import write_runtime_table

        told = read_settings(settings, RowsJob)
        write_runtime_table(records, episode or [], told.methods, told.absent, published or [], out)


@commands.command("runtime_summary")
def runtime_summary(
    records: Annotated[list[Path], typer.Argument(help="records of the timing, one a method")],
    summary: Annotated[Literal["memory", "detail"], typer.Option(help="which of the paper's two tables")],
    settings: SettingsFile,
    out: Stem,
    episode: Annotated[list[Path] | None, typer.Option(help="an episode on the scene, for the PSNR")] = None,
    log: Log = None,
) -> None:
    """Write one of the paper's two tables of selection times as csv, md and tex."""
    with job(log):
        from avs.config.report_jobs import SummaryJob
        from avs.report.tables.runtime_summary import write_runtime_summary

        told = read_settings(settings, SummaryJob)
        published = Path(told.published)
        write_runtime_summary(summary, records, episode or [], told.methods, told.absent, published, out)


@commands.command()
def report(results: Annotated[Path, typer.Argument(help="folder of a run's results, such as results/ci")]) -> None:
    """Tabulate what is there of a run that has not come to its end, each gap with its cause, and print the tables."""
    with job(None):
        from avs.config.run_plan import read_plan
        from avs.config.unfinished_run import unfinished
        from avs.report.incomplete import write_incomplete_tables

        plan = read_plan(results)
        out = results / "tables_incomplete"
        tables, left_out = write_incomplete_tables(unfinished(plan), out)
        print("\n".join([*tables, *left_out, *([f"All tables: {out}"] if tables else [])]))
