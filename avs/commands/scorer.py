"""Commands that make distortion data and train cross-reference scorers on them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from avs.commands.arguments import Log, Out, SettingsFile
from avs.system.compatibility import limit_threads
from avs.system.jobs import job

commands = typer.Typer()


@commands.command()
def distortions(scene: Path, seed: int, settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Fit a training scene and keep renderings of it with their SSIM maps."""
    from avs.iqa.cross_reference.renders import make_renders
    from avs.iqa.cross_reference.scorer_settings import RenderJob

    with job(log) as console:
        limit_threads()
        make_renders(scene, out, RenderJob.model_validate(json.loads(settings.read_text())), seed, console.progress)


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
    from avs.iqa.cross_reference.scorer_settings import ScorerSettings
    from avs.iqa.cross_reference.training import train

    with job(log) as console:
        limit_threads()
        values = json.loads(settings.read_text())
        checked = ScorerSettings.model_validate(values["scorer"])
        train(training, held_out, weights, card, checked, console.progress, values["device"])
