"""The command that holds a run to the results that are kept with the project."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from avs.system.job_process import job

commands = typer.Typer()


@commands.command()
def reference(
    results: Annotated[Path, typer.Argument(help="folder of a finished run's results")] = Path("results/ci"),
    folder: Annotated[Path | None, typer.Option(help="the reference; that of the run's name by default")] = None,
    keep: Annotated[str | None, typer.Option(help="make the run the reference; the command that made it")] = None,
    figure: Annotated[list[str] | None, typer.Option(help="with --keep, a figure that is kept, too")] = None,
) -> None:
    """Compare a run with the results in results/reference, value by value; status 1 if it is too far from them."""
    with job(None):
        from avs.config.run_episodes import episodes_of_run
        from avs.report import kept_results as kept

        episodes = episodes_of_run(results)
        place = folder or Path("results/reference") / results.resolve().name
        if keep is not None:
            kept.keep(results, episodes, place, keep, figure or [])
            return
        bits = kept.same_bits(results, episodes, place)
        print("the same bits are expected" if bits else "other numerics, packages or machines: tolerances hold")
        found = list(kept.deviations(results, place))
        for each in found:
            print(f"{'TOO FAR: ' if kept.is_too_far(each, bits) else ''}{each.line()}")
        if names := kept.not_compared(place):
            print(f"without single values of their own, so not compared: {', '.join(names)}")
        too_far = not found or any(kept.is_too_far(each, bits) for each in found)
    if too_far:  # behind the job, which takes the end of a program for a fault
        sys.exit(1)
