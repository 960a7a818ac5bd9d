"""The command that makes scenes, and those that look at data sets and find poses before a run."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from avs.commands.arguments import Log, Out, SettingsFile
from avs.system.errors import UserError
from avs.system.job_process import job
from avs.system.records import read_settings

if TYPE_CHECKING:
    from avs.representations.needed_points import NeededPoints

commands = typer.Typer()
of_folders = typer.Typer(no_args_is_help=True, help="Look at data sets and find poses of photographs, before a run.")


@commands.command()
def scene(settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Prepare a scene, as the reader of its data set does."""
    with job(log):
        from avs.config.jobs import SceneJob

        told = read_settings(settings, SceneJob)
        told.scene.prepare(told.dataset, out)
        if told.points is not None:
            _check_points(out, told.points)


def _check_points(folder: Path, needed: NeededPoints) -> None:
    """Take the scene away again if a reconstruction could not start from its points."""
    from avs.representations.needed_points import check_points
    from avs.scene.scene import read_scene

    try:
        check_points(read_scene(folder), needed)
    except UserError:
        shutil.rmtree(folder)
        raise


@of_folders.command()
def check(
    name: Annotated[str, typer.Argument(help="a data set of workflows/config/datasets, or a source, such as captures")],
    folder: Annotated[Path, typer.Argument(help="where it lies")],
    videos: Annotated[Path | None, typer.Option(help="folder of the videos, for realestate10k")] = None,
) -> None:
    """Say what is there of a data set and what is missing; a fault is found without reading the pixels of pictures."""
    with job(None) as console:
        from avs.config.data_set_check import check_data_set

        check_data_set(name, folder, videos, console.progress)
