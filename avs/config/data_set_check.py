"""What is there of a data set and what is missing, before a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from avs.datasets.folder_reader import FolderReader
from avs.datasets.published_archives import Archive
from avs.datasets.reader_registry import readers
from avs.system.code_inputs import ROOT
from avs.system.errors import UserError
from avs.system.files import explained
from avs.system.models import first_fault

CONFIGURATIONS = ROOT / "workflows" / "config" / "datasets"
"""Where the configurations of the paper's data sets lie, a file for each, called after it."""


def check_data_set(name: str, folder: Path, videos: Path | None, tell: Callable[[str], None]) -> None:
    """Look at every scene of a data set and tell of each, and of those that are missing, in a line.

    Args:
        name: a data set of ``CONFIGURATIONS``, or a source; of a source, all scenes that are there are looked at.
        folder: where it lies.
        videos: folder of its videos, of a data set that has some beside its texts; None for ``videos`` in ``folder``.
        tell: receives each line.

    Raises:
        UserError: the name is unknown; nothing is there; or, at the end, a scene is missing or damaged.
    """
    reader = _reader(name, folder, videos)
    with explained():
        scenes, missing = reader.scenes(), reader.left_out()
        whole = sum([_is_whole(scene, settings, tell) for scene, settings in scenes.items()])
    for scene, reason in missing.items():
        tell(f"{scene}: {reason}")
    tell(f"{name}: {whole} of {len(scenes) + len(missing)} scenes are there")
    if whole < len(scenes) + len(missing):
        fault = f"{len(scenes) + len(missing) - whole} scenes are missing or damaged"
        raise UserError(folder, fault, "get them as docs/data.md says, or leave them out by `only`")


def archives_of(name: str) -> tuple[Archive, ...]:
    """Return what is published of a data set and may be fetched without being asked for terms.

    Raises:
        UserError: the name is unknown, or its page has to be visited.
    """
    archives = _kind(name).archives
    if not archives:
        fault = "has no archive that may be fetched without accepting terms"
        where = CONFIGURATIONS / f"{name}.yaml"
        remedy = f"get it from the page that {where} names" if where.is_file() else "copy your files yourself"
        raise UserError(f"data set {name}", fault, remedy)
    return archives


def _is_whole(name: str, settings: FolderReader, tell: Callable[[str], None]) -> bool:
    try:
        tell(f"{name}: {settings.examine()}")
    except UserError as error:
        tell(f"{name}: {error}")
        return False
    return True


def _reader(name: str, folder: Path, videos: Path | None) -> FolderReader:
    """Return the settings of a data set in ``folder``."""
    told = _told(name) | {"folder": str(folder)}
    kind = _kind(name)
    if "axes" in kind.model_fields:
        told.setdefault("axes", "opengl")  # which are right is seen when points are triangulated, not here
    if "videos" in kind.model_fields:
        told["videos"] = str(videos or folder / "videos")
    elif videos is not None:
        raise UserError(f"data set {name}", "has no videos", "leave the option --videos out")
    try:
        return kind.model_validate(told)
    except ValidationError as error:
        place, fault = first_fault(error)
        path = CONFIGURATIONS / f"{name}.yaml"
        remedy = f"correct {path}" if path.is_file() else "correct it"
        raise UserError(f"data set {name}: {place}", fault, remedy) from None


def _kind(name: str) -> type[FolderReader]:
    """Return the reader of a data set."""
    kind = readers()[_told(name)["source"]]
    if not issubclass(kind, FolderReader):
        raise UserError(f"data set {name}", "is made on the spot from no files of yours", "name another one")
    return kind


def _told(name: str) -> dict[str, Any]:
    """Return what a configuration says of a data set, or its source alone."""
    path = CONFIGURATIONS / f"{name}.yaml"
    if name.isidentifier() and path.is_file():
        content: Mapping[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
        return dict(content["datasets"][name])
    if name not in readers():
        known = sorted({*readers(), *(found.stem for found in CONFIGURATIONS.glob("*.yaml"))})
        raise UserError(f"data set {name}", "is unknown", f"name one of {', '.join(known)}")
    return {"source": name}
