"""What a capture of plain photographs was made of, kept in its folder: another source of its name is noticed."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from pydantic import Field

from avs.datasets.image_names import is_image
from avs.system.errors import UserError
from avs.system.file_walk import walk_files
from avs.system.files import file_hash
from avs.system.lists_of_names import some_of
from avs.system.models import StrictModel
from avs.system.records import read_record

NAME = "made_of.json"
"""The file in the folder of a capture."""


class Origin(StrictModel):
    """What the poses of a capture were found from."""

    place: str = Field(description="the folder of the photographs, or the video, without links")
    files: dict[str, str] = Field(description="SHA-256 of each photograph by its path in the folder, or of the video")
    lens: str = Field(description="COLMAP's model of the camera")
    ordered: bool = Field(description="whether names follow a path")
    rate: float | None = Field(description="frames of the video that are taken a second; null for photographs")
    made: dict[str, str] = Field(
        default={}, description="SHA-256 of each file of the capture itself, its pictures and poses, by its path in it"
    )


def photographs_in(source: Path, out: Path) -> list[Path]:
    """Return the pictures in a folder and its subfolders, ascending, without those in ``out``, if that lies there.

    Raises:
        OSError: a folder cannot be read.
    """
    return files_in(source, out, is_image)


def files_in(source: Path, out: Path, wanted: Callable[[Path], bool]) -> list[Path]:
    """Return the files of a kind in a folder and its subfolders, ascending, without those in ``out``.

    Raises:
        OSError: a folder cannot be read.
    """
    own = out.resolve()
    found = sorted(path for path in walk_files(source) if wanted(path))
    if not own.is_relative_to(source.resolve()):
        return found
    return [path for path in found if not _is_below(path.resolve(), own)]


def origin_of(source: Path, out: Path, *, lens: str, ordered: bool, rate: float) -> Origin:
    """Return what a capture ``out`` of this source and these options would be made of.

    Raises:
        OSError: a file cannot be read.
    """
    is_video = source.is_file()
    paths = [source] if is_video else photographs_in(source, out)
    root = source.parent if is_video else source
    return Origin(
        place=_text(source.resolve()),
        files={_text(path.relative_to(root)): file_hash(path) for path in paths},
        lens=lens,
        ordered=ordered or is_video,
        rate=rate if is_video else None,
    )


def files_made(capture: Path) -> dict[str, str]:
    """Return the pictures and poses of a capture, as ``Origin.made`` has them.

    Raises:
        OSError: a file cannot be read.
    """
    found = [*(path for path in walk_files(capture / "images") if is_image(path)), *walk_files(capture / "sparse")]
    return {_text(path.relative_to(capture)): file_hash(path) for path in sorted(found)}


def check_origin(out: Path, origin: Origin) -> None:
    """See that the capture that is there was made of the same, and is as it was made.

    Of the same files in another place is as good. Of a capture that does not tell what it holds, as those of earlier
    versions, the pictures must be copies of the photographs.

    Raises:
        UserError: it was made of something else, or does not tell; or its own files have changed.
    """
    remedy = "remove it to find the poses anew, or rename the source"
    if not (out / NAME).is_file():
        raise UserError(out, f"is there already, and no {NAME} in it tells what it was made of", remedy)
    before = read_record(out / NAME, Origin, remedy)
    changed = sorted(
        name for name in before.files.keys() | origin.files.keys() if before.files.get(name) != origin.files.get(name)
    )
    if changed and before.place != origin.place:
        raise UserError(out, f"was made of {before.place}", remedy)
    if changed:
        raise UserError(out, f"was made before these changed, came or went: {some_of(changed)}", remedy)
    if before.model_copy(update={"place": origin.place, "made": {}}) != origin:
        raise UserError(out, f"was made with other options ({_options(before)})", remedy)
    if others := _changed_files(out, before):
        fault = f"its own files have changed, come or gone since its poses were found: {some_of(others)}"
        raise UserError(out, fault, "put them back, or remove it to find the poses anew")


def _changed_files(out: Path, before: Origin) -> list[str]:
    """Return the files of a capture that are not as they were made, ascending."""
    expected, found = before.made, files_made(out)
    if not expected:  # of an earlier version: pictures that are no frames were copied
        if before.rate is not None:
            return []
        expected = {f"images/{name}": told for name, told in before.files.items()}
        found = {name: told for name, told in found.items() if name.startswith("images/")}
    return sorted(name for name in expected.keys() | found.keys() if expected.get(name) != found.get(name))


def _is_below(path: Path, folder: Path) -> bool:
    """Whether a path lies in a folder, or in one that an interrupted job left beside it; all are resolved."""
    if not path.is_relative_to(folder.parent):
        return False
    name = path.relative_to(folder.parent).parts[0]
    return name == folder.name or name.startswith(f".{folder.name}-")


def _options(origin: Origin) -> str:
    told = f"lens {origin.lens}, {'ordered' if origin.ordered else 'not ordered'}"
    return told if origin.rate is None else f"{told}, {origin.rate:g} frames a second"


def _text(path: Path) -> str:
    """Return a path as text that can be written, whatever its bytes are."""
    return os.fsencode(path).decode(errors="backslashreplace")
