"""Archives of a data set that anyone may fetch without being asked for terms, and how they become its folder."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from avs.system.archives import unpack
from avs.system.downloads import download
from avs.system.files import file_hash, write_json
from avs.system.lists_of_names import some_of


@dataclass(frozen=True)
class Archive:
    """A file that is published.

    Attributes:
        url: where.
        size: in bytes, if known.
        sha256: in hexadecimal, if known. Google's storage states an MD5 with each file, which is compared in any case.
    """

    url: str
    size: int | None = None
    sha256: str | None = None

    @property
    def name(self) -> str:
        """The file's own name."""
        return self.url.rpartition("/")[2]


def fetch_archives(
    archives: Sequence[Archive], folder: Path, keep: bool, progress: Callable[[str], None]
) -> list[Path]:
    """Download and unpack those archives that are not in ``folder`` yet, one after another.

    What was unpacked is remembered in ``folder/<archive>.json``: another call passes over it unless some of it is gone.
    Then the archive is fetched once more, and what is still there stays as it is. A download that broke off is gone on
    with.

    Args:
        archives: of the data set.
        folder: the data set's; it is made if need be.
        keep: leave the archives there; else each is removed once it is unpacked.
        progress: receives lines.

    Returns:
        The marks of the archives.

    Raises:
        UserError: see ``avs.system.downloads.download`` and ``avs.system.archives.unpack``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    return [_fetch(archive, folder, keep, progress) for archive in archives]


def _fetch(archive: Archive, folder: Path, keep: bool, progress: Callable[[str], None]) -> Path:
    mark, file = folder / f"{archive.name}.json", folder / archive.name
    before = _unpacked_before(mark)
    kept = [name for name in before if (folder / name).exists()]
    if before and kept == before:
        progress(f"{archive.name}: was unpacked here before ({mark})")
        return mark
    if before:
        gone = [name for name in before if name not in kept]
        progress(f"{archive.name}: was unpacked here before; gone since: {some_of(gone)}")
    if file.is_file():
        digest, unchecked = file_hash(file), archive.sha256
    else:
        digest, unchecked = _downloaded(archive, file, progress), None
    size, names = file.stat().st_size, unpack(file, folder, unchecked, kept)
    write_json(mark, {"url": archive.url, "sha256": digest, "bytes": size, "unpacked": names})
    if not keep:
        file.unlink()
    progress(f"{archive.name}: {', '.join(names)} in {folder}")
    return mark


def _downloaded(archive: Archive, file: Path, progress: Callable[[str], None]) -> str:
    """Fetch an archive to ``file`` and return its SHA-256, which has been compared."""
    progress(f"{archive.name}: {archive.url}")
    found = download(archive.url, file, progress, archive.size, archive.sha256)
    told = "hash verified" if found.verified else "no hash is stated to compare with"
    progress(f"{archive.name}: {found.size / 1e6:.0f} MB, {told}; unpacking")
    return found.sha256


def _unpacked_before(mark: Path) -> list[str]:
    """Return the names that a mark tells of; none if there is no mark, or it makes no sense."""
    try:
        told = json.loads(mark.read_text(encoding="utf-8"))["unpacked"]
        return [str(PurePosixPath(name).name) for name in told]
    except (OSError, ValueError, TypeError, KeyError):
        return []
