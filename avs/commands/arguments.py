"""Arguments that several commands share."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal

import typer

Device = Literal["cpu", "cuda"]
SceneFolder = Annotated[Path, typer.Argument(help="folder of a scene, as the rule scene makes it")]
Seed = Annotated[int, typer.Argument(help="seed of every random choice")]
Episodes = Annotated[list[Path], typer.Argument(help="records of episodes, episode.json")]
DeviceName = Annotated[Device, typer.Option(help="where to run")]
Log = Annotated[Path | None, typer.Option(help="file for everything that is printed")]
SettingsFile = Annotated[Path, typer.Option(help="settings, a JSON file written by the workflow")]
Out = Annotated[Path, typer.Option(help="what to write")]
Stem = Annotated[Path, typer.Option(help="path of what to write, without suffix")]
MethodWeights = Annotated[
    list[str] | None, typer.Option(help="METHOD=FILE, the weights of a method; once for each that needs some")
]
Weights = Annotated[Path | None, typer.Option(help="weights that the method needs, if any")]


def weights_by_method(told: list[str] | None) -> dict[str, Path]:
    """Return the files of ``MethodWeights`` by the identifier of the method."""
    return dict(_pairs(told))


def files_by_name(told: list[str] | None, names: Iterable[str]) -> dict[str, list[Path]]:
    """Return the files of an option ``NAME=FILE`` that can be given again and again, by name; ``names`` come first."""
    files: dict[str, list[Path]] = {name: [] for name in names}
    for name, path in _pairs(told):
        files.setdefault(name, []).append(path)
    return files


def _pairs(told: list[str] | None) -> list[tuple[str, Path]]:
    pairs = (each.partition("=") for each in told or [])
    return [(name, Path(path)) for name, _, path in pairs]
