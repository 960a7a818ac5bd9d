"""The command that shows an episode live."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from avs.system.errors import UserError
from avs.system.job_process import job

commands = typer.Typer()


@commands.command()
def view(
    episode: Annotated[Path, typer.Argument(help="episode.json, or its folder")],
    scene: Annotated[Path | None, typer.Option(help="folder of its scene; by default where the run has it")] = None,
    port: Annotated[int, typer.Option(min=1024, max=65535, help="of this machine")] = 8080,
) -> None:
    """Show an episode's model and cameras in a browser, on this machine alone, until the command is stopped."""
    with job(None):
        from avs.report.page.live_view import HOST, serve_episode

        record = episode / "episode.json" if episode.is_dir() else episode
        folder = scene or scene_of(record)
        server = serve_episode(record, folder, port)
        print(f"http://{HOST}:{port} shows {record.parent}; stop with Ctrl-C", flush=True)
        with suppress(KeyboardInterrupt):
            server.sleep_forever()


def scene_of(record: Path) -> Path:
    """Return the folder of the scene of an episode that lies where a run writes it.

    Raises:
        UserError: it lies elsewhere, or its scene is not there.
    """
    parts = record.absolute().parents
    if len(parts) < 6 or parts[4].name != "episodes":
        raise UserError(record, "does not lie where a run writes it", "name its scene with --scene")
    # Episodes of the tables `agnostic` and `sensitivity` lie two folders deeper than those of the run, on its scenes.
    run = parts[7] if len(parts) > 7 and parts[6].name in ("agnostic", "sensitivity") else parts[5]
    folder = run / "scenes" / parts[3].name / parts[2].name
    if not folder.is_dir():
        raise UserError(record, f"its scene is not in {folder}", "name the scene with --scene")
    return folder
