"""Files that appear whole or not at all, canonical JSON, and content hashes."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from avs.errors import UserError

_REMEDIES = {
    errno.ENOSPC: "free some space, then run again",
    errno.EDQUOT: "free some of your quota, then run again",
    errno.EFBIG: "raise the limit on file sizes, then run again",
    errno.EACCES: "give yourself the permission, or choose another folder",
    errno.EPERM: "give yourself the permission, or choose another folder",
    errno.EROFS: "choose a folder that can be written",
    errno.ENOENT: "check the path",
    errno.ENOTDIR: "check the path",
    errno.EISDIR: "check the path",
    errno.EIO: "check the disk, then run again",
}


@contextlib.contextmanager
def atomic_path(target: Path | str) -> Iterator[Path]:
    """Yield a temporary path beside ``target``; on success flush it to disk and rename it over ``target``.

    The temporary name keeps the suffix, because many writers choose their format by it. On any error the temporary file
    is removed and ``target`` is left as it was.
    """
    target = Path(target)
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.stem}-", suffix=target.suffix)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        _flush(temporary)
        # mkstemp makes the file private (0600); a result is as readable as any other file of the user.
        temporary.chmod(0o666 & ~_umask())
        os.replace(temporary, target)
        _flush(target.parent)
    except OSError as error:
        _name(error, target)
        raise
    finally:
        temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def atomic_folder(target: Path | str) -> Iterator[Path]:
    """Yield an empty temporary folder beside ``target``; on success rename it to ``target``, replacing what was there.

    Between the removal of an old folder and the rename there is an instant without ``target``; it never holds a mixture.
    """
    target = Path(target)
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}-"))
    try:
        yield temporary
        for path in temporary.rglob("*"):
            _flush(path)
        temporary.chmod(0o777 & ~_umask())
        if target.exists():
            shutil.rmtree(target)
        os.replace(temporary, target)
        _flush(target.parent)
    except OSError as error:
        _name(error, target)
        raise
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def write_text(target: Path | str, text: str) -> None:
    """Write ``text`` (UTF-8) to ``target`` atomically."""
    with atomic_path(target) as temporary:
        temporary.write_text(text, encoding="utf-8")


def canonical_json(value: Any) -> str:
    """Return ``value`` as JSON with sorted keys, two spaces of indentation, a newline at the end, and no NaN.

    Equal values give equal bytes.

    Raises:
        ValueError: ``value`` holds NaN or an infinity, which JSON cannot carry.
    """
    return json.dumps(value, sort_keys=True, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def write_json(target: Path | str, value: Any) -> None:
    """Write ``value`` to ``target`` atomically as canonical JSON."""
    write_text(target, canonical_json(value))


def file_hash(path: Path | str) -> str:
    """Return the SHA-256 of a file's bytes, in hexadecimal."""
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


@contextlib.contextmanager
def explained() -> Iterator[None]:
    """Turn an ``OSError`` inside the block, such as a full disk, into a ``UserError`` that names the file.

    A program puts its whole work into one such block; library code lets ``OSError`` pass.

    Raises:
        UserError: the block raised ``OSError``.
    """
    try:
        yield
    except OSError as error:
        fault = (error.strerror or str(error) or type(error).__name__).lower()
        remedy = _REMEDIES.get(error.errno or 0, "check the path and the disk, then run again")
        raise UserError(error.filename or "a file", fault, remedy) from error


def _name(error: OSError, target: Path) -> None:
    """Give ``error`` the name of the result where it has none or a temporary one: a failed write() knows no name."""
    if error.filename is None or Path(error.filename).name.startswith("."):
        error.filename = str(target)


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
