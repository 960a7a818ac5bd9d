"""The command that tells how far a run has come."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Annotated

import typer

from avs.system.job_process import job

commands = typer.Typer()

_CLEAR = "\x1b[H\x1b[J"


@commands.command()
def status(
    results: Annotated[Path, typer.Argument(help="folder of a run's results")] = Path("results/ci"),
    every: Annotated[float, typer.Option(min=1, help="seconds between looks, in a terminal while a run is alive")] = 5,
    once: Annotated[bool, typer.Option("--once", help="look once")] = False,
) -> None:
    """Print how many jobs of a run are done, running, failed and to come, and the time left."""
    with job(None):
        from avs.config.run_plan import PLAN_NAME, read_plan
        from avs.config.run_progress import job_statuses, mean_seconds, status_lines
        from avs.system.resume import runs_in

        follows = sys.stdout.isatty() and not once
        while True:
            is_alive = next(runs_in(Path.cwd()), None) is not None
            statuses = job_statuses(read_plan(results), (results / PLAN_NAME).stat().st_mtime, is_alive)
            text = "\n".join(status_lines(statuses, mean_seconds(results), is_alive))
            print((_CLEAR if follows else "") + text, flush=True)
            if not (follows and is_alive):
                break
            time.sleep(every)
