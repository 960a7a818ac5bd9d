"""Commands that make scenes."""

from __future__ import annotations

from pathlib import Path

import typer

from avs.commands.arguments import Log, Out, SettingsFile
from avs.system.job_process import job
from avs.system.records import read_record

commands = typer.Typer()


@commands.command("embedded_scene")
def embedded_scene(pattern: str, seed: int, settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Make an embedded scene."""
    from avs.datasets.embedded import make_scene
    from avs.datasets.embedded.embedded_settings import EmbeddedSettings

    with job(log):
        make_scene(pattern, seed, read_record(settings, EmbeddedSettings), out)


@commands.command("capture_scene")
def capture_scene(source: Path, settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Turn a folder in COLMAP layout into a scene."""
    from avs.datasets.capture_settings import CaptureSettings
    from avs.datasets.captures import prepare

    with job(log):
        prepare(source, out, read_record(settings, CaptureSettings))
