"""The command that makes scenes, and those that look at data sets and find poses before a run."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from avs.commands.arguments import Log, Out, SettingsFile
from avs.system.errors import UserError
from avs.system.job_process import job
from avs.system.records import read_settings

Lens = Literal["SIMPLE_PINHOLE", "SIMPLE_RADIAL", "OPENCV", "OPENCV_FISHEYE"]

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


@of_folders.command()
def get(
    name: Annotated[str, typer.Argument(help="a data set of workflows/config/datasets that is published freely")],
    folder: Annotated[Path, typer.Argument(help="where its archives are unpacked")],
    keep: Annotated[bool, typer.Option("--keep", help="keep the archives once they are unpacked")] = False,
) -> None:
    """Download a data set's archives and unpack them; run again, it goes on where a download broke off."""
    with job(None) as console:
        from avs.config.data_set_check import archives_of
        from avs.datasets.published_archives import fetch_archives

        fetch_archives(archives_of(name), folder, keep, console.progress)


@of_folders.command()
def pose(
    source: Annotated[Path, typer.Argument(help="folder of photographs, or a video")],
    out: Annotated[Path, typer.Option(help="the capture to write: images/ and sparse/0; one made of the same stays")],
    lens: Annotated[Lens, typer.Option(help="COLMAP's model of the camera")] = "SIMPLE_RADIAL",
    ordered: Annotated[bool, typer.Option(help="photographs follow a path by name, as those of a video do")] = False,
    rate: Annotated[float, typer.Option(min=0.01, help="frames of a video that are taken a second")] = 2.0,
) -> None:
    """Find the poses of plain photographs, or of a video's frames, and write them as a capture in COLMAP's layout."""
    with job(None) as console:
        from avs.datasets.photograph_poses import write_capture

        write_capture(source, out, lens=lens, ordered=ordered, rate=rate, tell=console.progress)


@of_folders.command()
def unpack(
    archive: Annotated[Path, typer.Argument(help="ZIP or tar archive that was downloaded")],
    folder: Annotated[Path, typer.Argument(help="where its content goes, beside what is there")],
    sha256: Annotated[str | None, typer.Option(help="of the archive, where its page states it")] = None,
) -> None:
    """Unpack an archive inside of a folder: no member leaves it, and nothing that is there is replaced."""
    with job(None) as console:
        from avs.system.archives import unpack as run

        console.progress(f"{folder}: {', '.join(run(archive, folder, sha256))}")
