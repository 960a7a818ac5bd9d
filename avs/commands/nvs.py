"""Commands that run episodes of view synthesis."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from avs.commands.arguments import (
    DeviceName,
    Log,
    MethodWeights,
    Out,
    SceneFolder,
    Seed,
    SettingsFile,
    Weights,
    weights_by_method,
)
from avs.system.compatibility import prepare_torch
from avs.system.job_process import job
from avs.system.records import read_settings

commands = typer.Typer()


@commands.command()
def episode(
    scene: SceneFolder,
    seed: Seed,
    settings: SettingsFile,
    out: Out,
    weights: Weights = None,
    views: Annotated[Path | None, typer.Option(help="views.json of a method that is a program of its own")] = None,
    follow: Annotated[Path | None, typer.Option(help="episode.json of the method whose views are captured")] = None,
    log: Log = None,
) -> None:
    """Run one episode: one method on one scene with one seed."""
    with job(log) as console:
        from avs.nvs.episode_settings import EpisodeSettings
        from avs.nvs.experiment import run_episode

        prepare_torch()
        checked = read_settings(settings, EpisodeSettings)
        run_episode(scene, checked, seed, weights, out, console.progress, views, follow)


@commands.command("common_states")
def common_states(
    scene: SceneFolder,
    seed: Seed,
    settings: SettingsFile,
    out: Out,
    weights: MethodWeights = None,
    log: Log = None,
) -> None:
    """Let all methods score the same candidates of one reconstruction, and measure the truth of them."""
    with job(log) as console:
        from avs.nvs.common_states import write_common_states
        from avs.nvs.common_states_settings import CommonStatesJob

        prepare_torch()
        told, files = read_settings(settings, CommonStatesJob), weights_by_method(weights)
        write_common_states(scene, told, seed, files, out, console.progress)


@commands.command()
def replay(
    scene: SceneFolder,
    episode: Annotated[Path, typer.Argument(help="its record, episode.json, possibly with another list of views")],
    out: Out,
    device: DeviceName = "cpu",
    log: Log = None,
) -> None:
    """Run an episode again on the views that its record lists."""
    with job(log) as console:
        from avs.nvs.experiment import replay_episode

        prepare_torch()
        replay_episode(scene, episode, device, out, console.progress)
