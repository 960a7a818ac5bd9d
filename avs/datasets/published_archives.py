"""Archives of a data set that anyone may fetch without being asked for terms, and how they become its folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from avs.system.archives import unpack
from avs.system.downloads import download
from avs.system.files import file_hash, write_json


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

    What was unpacked is remembered in ``folder/<archive>.json``: another call passes over it. A download that broke off
    is gone on with.

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
    if mark.is_file():
        progress(f"{archive.name}: was unpacked here before ({mark})")
        return mark
    if not file.is_file():
        progress(f"{archive.name}: {archive.url}")
        found = download(archive.url, file, progress, archive.size, archive.sha256)
        told = "hash verified" if found.verified else "no hash is stated to compare with"
        progress(f"{archive.name}: {found.size / 1e6:.0f} MB, {told}; unpacking")
    digest, size = file_hash(file), file.stat().st_size
    names = unpack(file, folder, archive.sha256)
    write_json(mark, {"url": archive.url, "sha256": digest, "bytes": size, "unpacked": names})
    if not keep:
        file.unlink()
    progress(f"{archive.name}: {', '.join(names)} in {folder}")
    return mark
