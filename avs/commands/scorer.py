"""Commands that make distortion data and train cross-reference scorers on them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from avs.commands.arguments import Log, Out, SceneFolder, Seed, SettingsFile
from avs.system.compatibility import limit_threads
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()


@commands.command()
def distortions(scene: SceneFolder, seed: Seed, settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Fit a training scene and keep renderings of it with their SSIM maps."""
    with job(log) as console:
        from avs.iqa.cross_reference.distortion_renders import make_renders
        from avs.iqa.cross_reference.scorer_settings import RenderJob

        limit_threads()
        make_renders(scene, out, read_settings(settings, RenderJob), seed, console.progress)


@commands.command("scorer_train")
def scorer_train(
    settings: SettingsFile,
    weights: Annotated[Path, typer.Option(help="checkpoint to write")],
    card: Annotated[Path, typer.Option(help="model card to write")],
    training: Annotated[list[Path], typer.Option(help="renderings of a training scene")],
    held_out: Annotated[list[Path], typer.Option(help="renderings of a scene that only measures")],
    log: Log = None,
) -> None:
    """Train the scorer on renderings."""
    with job(log) as console:
        from avs.config.jobs import TrainingJob
        from avs.iqa.cross_reference.training import train

        limit_threads()
        told = read_settings(settings, TrainingJob)
        train(training, held_out, weights, card, told.scorer, console.progress, told.device)
