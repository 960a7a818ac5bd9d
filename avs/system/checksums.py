"""Lists of hashes as ``sha256sum`` writes and checks them: a line for each file of SHA-256, two blanks, and path."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from avs.system.errors import UserError
from avs.system.files import file_hash

LIST = "SHA256SUMS"
"""Name of the list that lies beside committed files."""

_HASH_LENGTH = 64


def checksum_lines(paths: Iterable[Path], folder: Path | None = None) -> str:
    """Return the list of these files, whose paths start from ``folder``, or from the current one."""
    return "".join(f"{file_hash(path if folder is None else folder / path)}  {path}\n" for path in paths)


def read_checksums(path: Path) -> dict[str, str]:
    """Return the hashes of a list by path; lines that are none of such a list are passed over.

    Raises:
        OSError: the list cannot be read.
    """
    lines = path.read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    told = (line for line in lines if len(line) > _HASH_LENGTH + 2 and not line.startswith("#"))
    return {line[_HASH_LENGTH + 2 :]: line[:_HASH_LENGTH] for line in told}


def check_listed(path: Path, remedy: str) -> None:
    """Check a committed file against the list beside it; where there is no list, nothing is known of the file.

    Raises:
        UserError: the list does not name the file, or has another hash of it.
        OSError: a file cannot be read.
    """
    listed = path.with_name(LIST)
    if not listed.is_file():
        return
    told = read_checksums(listed).get(path.name)
    if told is None or told != file_hash(path):
        fault = f"is not in {listed}" if told is None else f"is not the file whose hash is in {listed}"
        raise UserError(path, fault, remedy)
