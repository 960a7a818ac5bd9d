"""The command line: the commands of every stage, each named exactly as the rule that calls it.

A stage's commands are in the file named as its rules, ``workflows/rules/<stage>.smk``. Rules pass every path that a
command reads or writes. ``python -m avs COMMAND --help`` lists the arguments.
"""

from __future__ import annotations

import gc
import io
import sys
from pathlib import Path
from typing import Annotated

import typer

from avs.commands import (
    agnostic,
    common,
    data,
    figures,
    metric_parameters,
    nvs,
    page,
    progress,
    reference,
    report,
    runtime,
    scorer,
    sensitivity,
    sfm,
    slam,
    view,
    weights,
)
from avs.system.compatibility import prepare_environment
from avs.system.job_process import remember_sources
from avs.system.parent_process import die_with_parent

HELP = "Active view selection. One command per rule of the workflow, of the same name; every path is an argument."
STAGES = (
    common,
    data,
    scorer,
    metric_parameters,
    nvs,
    runtime,
    sensitivity,
    agnostic,
    sfm,
    slam,
    report,
    figures,
    page,
    progress,
    reference,
    view,
)

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False, help=HELP)


@app.callback()
def sources(
    made_of: Annotated[
        str | None, typer.Option(help="tells of the files that a job reads and no job makes; kept beside its log")
    ] = None,
    read: Annotated[
        list[str] | None, typer.Option(help="file that a job reads and another job makes; its hash is kept there, too")
    ] = None,
    planned_with: Annotated[
        Path | None, typer.Option(help="list of the code that a run is planned with; a job of other code fails")
    ] = None,
) -> None:
    """Take what holds for every command."""
    remember_sources(made_of, read or [], planned_with, sys.argv[1:])


for stage in STAGES:
    app.add_typer(stage.commands)
app.add_typer(weights.commands, name="weights")
app.add_typer(data.of_folders, name="data")


def main() -> None:
    """Run the command line."""
    die_with_parent()
    prepare_environment()
    # Libraries make hundreds of thousands of objects that stay; looking for garbage among them so much less often saves
    # a tenth of a job's start.
    gc.set_threshold(50_000)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # tables hold arrows and dashes, which not every terminal can show
            stream.reconfigure(errors="backslashreplace")
    app()
