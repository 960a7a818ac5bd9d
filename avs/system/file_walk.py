"""All files below a folder, through links."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path


def walk_files(folder: Path, *, strict: bool = True) -> Iterator[Path]:
    """Yield the files below ``folder``, through links to folders as well, but through each folder once.

    Links to a folder that holds the one with the link are passed over: they lead to all that is there, up to the whole
    disk. Pipes and devices are no files.

    Args:
        folder: where to begin.
        strict: whether a folder that cannot be read, or a link that leads to itself, is an error; else passed over.

    Raises:
        OSError: there is such a one.
    """
    allowed = () if strict else (OSError,)
    seen: set[tuple[int, int]] = set()
    waiting = [folder] if folder.is_dir() else []
    while waiting:
        current = waiting.pop()
        status = current.stat()
        if (status.st_dev, status.st_ino) in seen:
            continue
        seen.add((status.st_dev, status.st_ino))
        with suppress(*allowed), os.scandir(current) as entries:  # a path for each entry would take ten times as long
            for entry in sorted(entries, key=lambda entry: entry.name):
                with suppress(*allowed):
                    if entry.is_dir():
                        if not (entry.is_symlink() and current.resolve().is_relative_to(Path(entry.path).resolve())):
                            waiting.append(current / entry.name)
                    elif entry.is_file():
                        yield current / entry.name
