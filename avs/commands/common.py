"""Commands of what all stages share, and those that look after a run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from avs.commands.arguments import Log
from avs.system.compatibility import prepare_torch
from avs.system.job_process import job

commands = typer.Typer()


@commands.command()
def kernels(
    kind: Annotated[str, typer.Argument(help="kind of representations")],
    log: Log = None,
) -> None:
    """Compile the CPU kernels of a kind of representations, so that no episode has to."""
    with job(log):
        from avs.representations.kinds import compile_kernels

        prepare_torch()
        compile_kernels(kind)


@commands.command()
def schemas(out: Annotated[Path, typer.Option(help="folder to write to")] = Path("workflows/schemas")) -> None:
    """Generate the JSON schemas of the configuration, the scene file and the records."""
    with job(None):
        from avs.config.schemas import write_schemas

        write_schemas(out)


@commands.command(
    context_settings={"allow_extra_args": True, "ignore_unknown_options": True},
    options_metavar="[ARGUMENTS OF SNAKEMAKE]...",
)
def resume(context: typer.Context) -> None:
    """Complete a killed run: unlock, unless a run is alive, then call snakemake with the arguments that follow."""
    with job(None):
        from avs.system.resume import resume as run

        run(context.args)
