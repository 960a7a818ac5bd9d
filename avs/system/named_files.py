"""The files that somebody's settings name, so that a change of one is seen."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path

from avs.system.code_inputs import with_contents
from avs.system.errors import UserError
from avs.system.file_walk import walk_files
from avs.system.files import CAN_BE_NAMED, can_be_named, explained

MOST = 10_000
"""Files below a named folder: more would take seconds at each look."""


def named_files(settings: object) -> Iterator[Path]:
    """Yield the files that settings name, however deep; of a folder those below it, as ``with_contents`` finds them.

    A text names a file if there is one; a folder only if it has a separator or begins with ``~``, which stands for the
    home of the user, because plain words are names of folders by chance.

    Args:
        settings: a value of JSON, or a path, in mappings and lists.

    Raises:
        UserError: Snakemake cannot take a file's name, a folder cannot be read, or it holds more than ``MOST`` files.
    """
    if isinstance(settings, Mapping):
        settings = list(settings.values())
    if isinstance(settings, list | tuple | set | frozenset):
        for each in settings:
            yield from named_files(each)
    elif isinstance(settings, str | os.PathLike):
        yield from _files_of(settings)


def _files_of(told: str | os.PathLike[str]) -> Iterator[Path]:
    path = _existing(told)
    if path is None or (path.is_dir() and isinstance(told, str) and os.sep not in told and not told.startswith("~")):
        return
    with explained():
        if path.is_dir() and len(list(islice(walk_files(path), MOST + 1))) > MOST:
            fault = f"is named in the configuration and holds more than {MOST} files, too many to watch for changes"
            raise UserError(path, fault, "name a file in it, or a smaller folder")
        found = with_contents([str(path)])
    for file in map(Path, found):
        if not can_be_named(file):
            raise UserError(file, "is named in the configuration, and the workflow cannot take its name", CAN_BE_NAMED)
        yield file


def _existing(told: str | os.PathLike[str]) -> Path | None:
    """Return the file or folder that is named, if there is one."""
    try:
        candidates = [Path(told), Path(told).expanduser()]
        return next((path for path in candidates if path.is_file() or path.is_dir()), None)
    except (OSError, ValueError, RuntimeError):  # no path, but a long text; or nobody's home
        return None
