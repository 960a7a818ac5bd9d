"""Commands that make distortion data, and train or fit on them what scores renderings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from avs.commands.arguments import Log, MethodWeights, Out, SceneFolder, Seed, SettingsFile, weights_by_method
from avs.system.compatibility import prepare_torch
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()


@commands.command()
def distortions(scene: SceneFolder, seed: Seed, settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Fit a training scene and keep renderings of it with their SSIM maps."""
    with job(log) as console:
        from avs.iqa.cross_reference.distortion_renders import make_renders
        from avs.iqa.cross_reference.scorer_settings import RenderJob

        prepare_torch()
        make_renders(scene, out, read_settings(settings, RenderJob), seed, console.progress)


Weights = Annotated[Path, typer.Option(help="checkpoint to write")]
Card = Annotated[Path, typer.Option(help="model card to write")]
Training = Annotated[list[Path], typer.Option(help="renderings of a training scene")]
HeldOut = Annotated[list[Path], typer.Option(help="renderings of a scene that only measures")]


@commands.command("scorer_train")
def scorer_train(
    settings: SettingsFile, weights: Weights, card: Card, training: Training, held_out: HeldOut, log: Log = None
) -> None:
    """Train the scorer on renderings."""
    with job(log) as console:
        from avs.config.scorer_jobs import TrainingJob
        from avs.iqa.cross_reference.training import train

        prepare_torch()
        told = read_settings(settings, TrainingJob)
        train(training, held_out, weights, card, told.scorer, console.progress, told.device)


@commands.command("statistics_fit")
def statistics_fit(
    settings: SettingsFile, weights: Weights, card: Card, training: Training, held_out: HeldOut, log: Log = None
) -> None:
    """Fit regressions of SSIM on plain statistics of renderings."""
    with job(log) as console:
        from avs.iqa.render_statistics.regression_fit import fit_statistics
        from avs.iqa.render_statistics.regression_settings import RegressionSettings

        prepare_torch()
        told = read_settings(settings, RegressionSettings)
        fit_statistics(training, held_out, weights, card, told, console.progress)


@commands.command("held_out_scores")
def held_out_scores(
    data: Annotated[Path, typer.Argument(help="renderings of a held-out scene")],
    other: Annotated[Path, typer.Option(help="renderings of another scene, for references that are none of its own")],
    settings: SettingsFile,
    out: Out,
    weights: MethodWeights = None,
    log: Log = None,
) -> None:
    """Let networks, metrics and plain numbers score the renderings of a held-out scene."""
    with job(log) as console:
        from avs.iqa.held_out.held_out_scores import write_held_out_scores
        from avs.iqa.held_out.held_out_settings import HeldOutJob

        prepare_torch()
        told, files = read_settings(settings, HeldOutJob), weights_by_method(weights)
        write_held_out_scores(data, other, told, files, out, console.progress)
