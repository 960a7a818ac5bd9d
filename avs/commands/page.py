"""Commands that make the page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from avs.commands.arguments import Episodes, Log, Out, SceneFolder, SettingsFile
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()


@commands.command("page_scene")
def page_scene(
    scene: SceneFolder,
    episodes: Episodes,
    settings: SettingsFile,
    out: Out,
    coverage: Annotated[list[Path] | None, typer.Option(help="coverage of an episode, coverage.json")] = None,
    states: Annotated[list[Path] | None, typer.Option(help="common states of a seed")] = None,
    log: Log = None,
) -> None:
    """Write the page's scripts of a scene: its cameras, photographs, episodes and states."""
    with job(log):
        from avs.config.report_jobs import PageSceneJob
        from avs.report.page.scene_scripts import SceneInputs, write_scene_scripts

        told = read_settings(settings, PageSceneJob)
        inputs = SceneInputs(scene, episodes, coverage or [], states or [])
        write_scene_scripts(inputs, told.methods, told.absent, told.page, told.share, out)


@commands.command("page_exploration")
def page_exploration(
    record: Annotated[Path, typer.Argument(help="exploration.json, with its maps beside it")],
    settings: SettingsFile,
    out: Annotated[Path, typer.Option(help="folder of the page")],
    log: Log = None,
) -> None:
    """Write the page's script of an exploration."""
    with job(log):
        from avs.config.report_jobs import PageExplorationJob
        from avs.report.page.exploration_script import write_exploration_script

        write_exploration_script(record, read_settings(settings, PageExplorationJob).page, out)


@commands.command()
def page(
    settings: SettingsFile,
    out: Annotated[Path, typer.Option(help="folder of the page")],
    table: Annotated[list[Path] | None, typer.Option(help="record of a table; in the order of the page")] = None,
    figure: Annotated[list[Path] | None, typer.Option(help="picture of a figure")] = None,
    card: Annotated[list[Path] | None, typer.Option(help="model card of a scorer")] = None,
    log: Log = None,
) -> None:
    """Write the page's frame, its tables and its figures."""
    with job(log):
        from avs.config.report_jobs import PageJob
        from avs.report.page.site import PageFacts, PageInputs, write_page

        told = read_settings(settings, PageJob)
        scenes = {name: told.scenes[name] for name in told.data_sets}
        facts = PageFacts(told.scale, scenes, told.methods, told.absent, told.config, told.explorations)
        write_page(PageInputs(table or [], figure or [], card or []), facts, out)
