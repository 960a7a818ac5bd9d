"""Arguments that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

Device = Literal["cpu", "cuda"]
Log = Annotated[Path | None, typer.Option(help="file for everything that is printed")]
SettingsFile = Annotated[Path, typer.Option(help="settings, a JSON file written by the workflow")]
Out = Annotated[Path, typer.Option(help="what to write")]
Stem = Annotated[Path, typer.Option(help="path of what to write, without suffix")]
Weights = Annotated[Path | None, typer.Option(help="weights that the method needs, if any")]
