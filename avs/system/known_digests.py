"""Hashes of large files, which are read again only where the file system tells of a change.

A photograph or a file of weights of some megabytes is hashed once, and then known by what its inode says: size, both
times, device and number. Unlike the time of modification alone, the time of the last change of the inode cannot be set
back by ``touch`` or ``rsync``.
"""

from __future__ import annotations

import functools
import time
from pathlib import Path

from avs.system.files import file_hash

KEPT = Path(".snakemake/digests_of_inputs.txt")
"""Where they are kept, a line each; its loss costs the time to read the files again."""

_SETTLED = 2_000_000_000
"""Nanoseconds after which another change of a file has another time, on any file system."""


def known_digest(path: str) -> str:
    """Return the SHA-256 of a file's bytes, from what is kept of earlier looks where the file has not changed since.

    Raises:
        OSError: the file cannot be read.
    """
    key = _key(path)
    found = _kept().get(key)
    if found is None:
        found = file_hash(path)
        if _key(path) == key:
            _keep(path, key, found)
    return found


def _key(path: str) -> str:
    status = Path(path).stat()
    numbers = (status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_dev, status.st_ino)
    return f"{' '.join(map(str, numbers))} {path}"


@functools.cache
def _kept() -> dict[str, str]:
    try:
        lines = KEPT.read_text(encoding="utf-8", errors="surrogateescape").split("\n")
    except OSError:
        return {}
    parts = (line.partition("  ") for line in lines)
    return {key: digest for digest, _, key in parts if len(digest) == 64}


def _keep(path: str, key: str, digest: str) -> None:
    """Append a line, which processes may do at a time; a file that was changed just now may be so again unseen."""
    status = Path(path).stat()
    young = time.time_ns() - max(status.st_mtime_ns, status.st_ctime_ns) < _SETTLED
    if young or "\n" in path or not KEPT.parent.is_dir():
        return
    _kept()[key] = digest
    try:
        with open(KEPT, "a", encoding="utf-8", errors="surrogateescape") as stream:
            stream.write(f"{digest}  {key}\n")
    except OSError:  # of a folder that cannot be written, nothing is kept
        return
