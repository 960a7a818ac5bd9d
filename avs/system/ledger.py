"""What a job wrote and what it was made from: a list of hashes beside its log, which is checked before the next run.

Snakemake knows that a file is there and when it was written, not whether it still holds what was written, nor whether
it was made from what is there now: times are lost where a folder is copied, and wrong where a clock was. The list is
one that ``sha256sum --check`` reads as well, since that passes over lines that begin with ``#``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from avs.system.checksums import checksum_lines, read_checksums
from avs.system.code_inputs import digest
from avs.system.files import SMALL, atomic_path, file_hash

SUFFIX = ".sha256"
_MADE_OF = "# made of "
_READ = "# read "
_OPENED = "# opened "


@dataclass(frozen=True)
class Damage:
    """What one job wrote and is not as it wrote it.

    Attributes:
        changed: files that hold something else.
        lacking: files that are not there, although others are.
        left: files that are as they were.
    """

    changed: tuple[Path, ...]
    lacking: tuple[Path, ...]
    left: tuple[Path, ...]


@dataclass(frozen=True)
class Origin:
    """What a job was made from.

    Attributes:
        stamp: tells of what it read and no job makes: the ``stamp`` of ``avs.system.code_inputs``; a program's command,
            or the digest of a command of the suite, stands behind it.
        read: hash of each file that it read and another job makes, by path.
        opened: hash of each file that it was found to have read beside those, by path.
    """

    stamp: str
    read: Mapping[str, str] = field(default_factory=dict)
    opened: Mapping[str, str] = field(default_factory=dict)

    def differs(self, stamp: str, read: Iterable[str]) -> bool:
        """Return whether a job with this stamp, which reads these files as they are now, would be another one.

        Files that are not there are for others to miss.
        """
        return self.stamp != stamp or set(self.read) != set(read) or self.is_outdated()

    def is_outdated(self, digest_of: Callable[[str], str | None] = digest) -> bool:
        """Return whether a file that was read holds something else now; one that no job makes may not be gone.

        Args:
            digest_of: returns the SHA-256 of a file, or None where there is none.
        """
        read = any(digest_of(path) not in (told, None) for path, told in self.read.items())
        return read or any(digest_of(path) != told for path, told in self.opened.items())


def ledger_of(log: Path) -> Path:
    """Return the path of the list of the job that writes to ``log``."""
    return log.with_name(f"{log.name}{SUFFIX}")


def write_ledger(log: Path, written: Iterable[Path], origin: Origin | None = None) -> None:
    """List what a job has written, beside its ``log``; files that it removed again are left out.

    Args:
        log: of the job.
        written: all files that it wrote.
        origin: what it was made from, where that is known.
    """
    paths = sorted({path.absolute() for path in written if path.is_file()})
    with atomic_path(ledger_of(log), listed=False) as temporary:
        temporary.write_text(
            _head(origin) + checksum_lines(map(from_here, paths)), encoding="utf-8", errors="surrogateescape"
        )


def from_here(path: Path) -> Path:
    """Return an absolute path as lists have it: from the current folder, where it is in there."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


def _head(origin: Origin | None) -> str:
    """Return the lines of a list that ``origin_of`` reads back."""
    if origin is None:
        return ""
    read = (f"{_READ}{told}  {path}\n" for path, told in origin.read.items())
    opened = (f"{_OPENED}{told}  {path}\n" for path, told in origin.opened.items())
    return "".join((f"{_MADE_OF}{origin.stamp}\n", *read, *opened))


def origin_of(log: Path) -> Origin | None:
    """Return what the job that wrote to ``log`` was made from, or None where no list says so."""
    try:
        lines = ledger_of(log).read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    except OSError:
        return None
    if not lines or not lines[0].startswith(_MADE_OF):
        return None
    return Origin(lines[0].removeprefix(_MADE_OF).strip(), _hashes(lines, _READ), _hashes(lines, _OPENED))


def _hashes(lines: Iterable[str], beginning: str) -> dict[str, str]:
    """Return the hashes in those lines of a list that begin so, by path."""
    told = (line.removeprefix(beginning).partition("  ") for line in lines if line.startswith(beginning))
    return {path: hashed for hashed, _, path in told}


def has_ended(log: Path) -> bool:
    """Return whether the last run of the job that writes to ``log`` ended well: all that it wrote is there."""
    try:
        return all(Path(path).is_file() for path in read_checksums(ledger_of(log)))
    except OSError:
        return False


def find_damage(folder: Path) -> list[Damage]:
    """Check every list in ``folder`` and return what is damaged; a job of which nothing is left is not.

    A small file is hashed at every look. A larger one is where it was written, replaced or renamed since it was listed,
    so that the look takes no longer with longer runs.
    """
    found = (_check(path) for path in sorted(folder.rglob(f"*{SUFFIX}")))
    return [damage for damage in found if damage is not None]


def damage_of(log: Path) -> Damage | None:
    """Return what is damaged of what the job that writes to ``log`` wrote, if anything is."""
    return _check(ledger_of(log))


def _check(ledger: Path) -> Damage | None:
    """Return what is damaged of one list, if anything is."""
    try:
        listed, since = read_checksums(ledger), ledger.stat().st_mtime_ns
    except OSError:
        return None
    paths = [Path(path) for path in listed]
    there = [path for path in paths if path.is_file()]
    changed = [path for path in there if _is_changed(path, listed[str(path)], since)]
    if not there or (len(there) == len(paths) and not changed):
        return None
    return Damage(tuple(changed), _without(paths, there), _without(there, changed))


def _is_changed(path: Path, told: str, since: int) -> bool:
    """Return whether a file has another hash than ``told`` at the time ``since``, in nanoseconds."""
    status = path.stat()
    if status.st_size > SMALL and max(status.st_mtime_ns, status.st_ctime_ns) <= since:
        return False
    return file_hash(path) != told


def _without(paths: Iterable[Path], others: Iterable[Path]) -> tuple[Path, ...]:
    left_out = set(others)
    return tuple(path for path in paths if path not in left_out)
