"""Commands of active SLAM."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from avs.commands.arguments import Log, Out, Seed, SettingsFile, Stem, Weights
from avs.system.compatibility import prepare_torch
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()

Explorations = Annotated[list[Path], typer.Argument(help="records of explorations, exploration.json")]


@commands.command()
def building(settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Make an embedded flat as a mesh with coloured vertices."""
    with job(log):
        from avs.config.slam_config import ApartmentBuilding, BuildingJob
        from avs.datasets.embedded import make_apartment

        told = read_settings(settings, BuildingJob).building
        assert isinstance(told, ApartmentBuilding)  # others are files already
        make_apartment(told.seed, out)


@commands.command()
def exploration(
    mesh: Annotated[Path, typer.Argument(help="the building, a .glb, .gltf, .obj or .ply file")],
    name: Annotated[str, typer.Argument(help="its name in records")],
    method: Annotated[str, typer.Argument(help="identifier of what chooses the paths, in records")],
    seed: Seed,
    settings: SettingsFile,
    out: Out,
    weights: Weights = None,
    log: Log = None,
) -> None:
    """Explore a building once; one that was killed goes on from its last checkpoint in the folder of its results."""
    with job(log) as console:
        from avs.slam.loop.exploration_checkpoint import program_of
        from avs.slam.loop.exploration_run import run_exploration
        from avs.slam.loop.slam_settings import SlamSettings

        prepare_torch()
        told = read_settings(settings, SlamSettings)
        code = program_of(told, weights)
        run_exploration(mesh, name, method, told, seed, weights, out, console.progress, code)


@commands.command("active_slam")
def active_slam(
    records: Explorations,
    settings: SettingsFile,
    published: Annotated[Path, typer.Option(help="the paper's values")],
    out: Stem,
    log: Log = None,
) -> None:
    """Write the table of explorations as csv, md and tex."""
    with job(log):
        from avs.config.slam_config import SlamFigureJob
        from avs.report.tables.active_slam import write_active_slam

        told = read_settings(settings, SlamFigureJob)
        absent = told.absent, told.absent_buildings
        write_active_slam(records, told.buildings, told.in_order, published, out, *absent)


@commands.command("slam_maps")
def slam_maps(
    records: Explorations,
    maps: Annotated[list[Path], typer.Option(help="maps.safetensors of each of them, in the same order")],
    out: Stem,
    log: Log = None,
) -> None:
    """Draw where each exploration went and what it covered, seen from above."""
    with job(log):
        from avs.report.figures.slam_maps import write_slam_maps

        write_slam_maps(records, maps, out)


@commands.command("slam_animation")
def slam_animation(
    record: Annotated[Path, typer.Argument(help="record of an exploration, exploration.json")],
    maps: Annotated[Path, typer.Option(help="its maps.safetensors")],
    mesh: Annotated[Path, typer.Option(help="the building")],
    out: Out,
    log: Log = None,
) -> None:
    """Show an exploration as a GIF: the camera's picture, the map's rendering, and the way from above."""
    with job(log):
        from avs.report.figures.slam_animation import write_slam_animation

        prepare_torch()
        write_slam_animation(record, maps, mesh, out)


@commands.command("slam_over_steps")
def slam_over_steps(records: Explorations, settings: SettingsFile, out: Stem, log: Log = None) -> None:
    """Draw the coverage over the actions of the robot."""
    with job(log):
        from avs.config.slam_config import SlamFigureJob
        from avs.report.figures.slam_over_steps import write_slam_over_steps

        told = read_settings(settings, SlamFigureJob)
        write_slam_over_steps(records, told.explored, told.methods, out)
