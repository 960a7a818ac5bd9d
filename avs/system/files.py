"""Files that appear whole or not at all, canonical JSON, and content hashes."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import re
import secrets
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from avs.system.errors import UserError

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


SMALL = 1_000_000
"""Bytes up to which a file is hashed at every look; a larger one is judged by its size and times first."""

CAN_BE_NAMED = "use names in UTF-8 without braces, angle brackets, line breaks or blanks at the end"
"""What helps where Snakemake cannot have a file as an input."""

_touched: list[Path] = []


def touched() -> tuple[Path, ...]:
    """Return the files that this process has written here, in order; some may have been removed since."""
    return tuple(_touched)


@contextlib.contextmanager
def atomic_path(target: Path | str, listed: bool = True) -> Iterator[Path]:
    """Yield a temporary path beside ``target``; on success flush it to disk and rename it over ``target``.

    The temporary name keeps the suffix, because many writers choose their format by it. On any error the temporary file
    is removed and ``target`` is left as it was. What is not ``listed`` is no result: ``touched`` leaves it out.
    """
    target = Path(target)
    temporary = target.with_name(f".{target.stem}-{secrets.token_hex(6)}{target.suffix}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary.touch(exist_ok=False)
        yield temporary
        publish(temporary, target)
        if listed:
            _touched.append(target)
    except OSError as error:
        _rename_in(error, temporary, target)
        raise
    finally:
        temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def atomic_folder(target: Path | str) -> Iterator[Path]:
    """Yield an empty temporary folder beside ``target``; on success rename it to ``target``, replacing what was there.

    Two folders cannot be exchanged in one step: for an instant there is no ``target``, but it never holds a part or a
    mixture. On any error the temporary folder is removed and ``target`` is left as it was.
    """
    target = Path(target)
    temporary = target.with_name(f".{target.name}-{secrets.token_hex(6)}")
    old = temporary.with_name(f"{temporary.name}-old")
    try:
        temporary.mkdir(parents=True)
        yield temporary
        for path in temporary.rglob("*"):
            _flush(path)
        _flush(temporary)
        if target.is_dir():
            os.replace(target, old)
        os.replace(temporary, target)
        _flush(target.parent)
        _touched.extend(sorted(path for path in target.rglob("*") if path.is_file()))
    except OSError as error:
        _rename_in(error, temporary, target)
        raise
    finally:
        if old.is_dir() and not target.exists():
            os.replace(old, target)
        for folder in (temporary, old):
            shutil.rmtree(folder, ignore_errors=True)


def publish(temporary: Path, target: Path) -> None:
    """Flush a finished file to disk and rename it to ``target``, in the same file system, over what was there."""
    _flush(temporary)
    os.replace(temporary, target)
    _flush(target.parent)


@contextlib.contextmanager
def temporary_folder(prefix: str) -> Iterator[Path]:
    """Yield an empty folder where the system keeps what is temporary; it is removed at the end.

    An ``OSError`` in the block that names no file, as those of a failed write(), names the folder.
    """
    with tempfile.TemporaryDirectory(prefix=prefix) as name:
        try:
            yield Path(name)
        except OSError as error:
            error.filename = error.filename or name
            raise


def write_text(target: Path | str, text: str) -> None:
    """Write ``text`` (UTF-8) to ``target`` atomically."""
    with atomic_path(target) as temporary:
        temporary.write_text(text, encoding="utf-8")


def canonical_json(value: object) -> str:
    """Return ``value`` as JSON with sorted keys, two spaces of indentation, a newline at the end, and no NaN.

    Equal values give equal bytes.

    Raises:
        ValueError: ``value`` holds NaN or an infinity, which JSON cannot carry.
    """
    return json.dumps(value, sort_keys=True, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def write_json(target: Path | str, value: object) -> None:
    """Write ``value`` to ``target`` atomically as canonical JSON."""
    write_text(target, canonical_json(value))


def file_hash(path: Path | str) -> str:
    """Return the SHA-256 of a file's bytes, in hexadecimal."""
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def can_be_named(path: Path) -> bool:
    """Whether Snakemake can have ``path`` as an input; ``CAN_BE_NAMED`` says what helps where it cannot.

    It takes braces for wildcards and angle brackets for path variables, and writes names as UTF-8.
    """
    text = str(path)
    return re.search("[{}<>\x00-\x1f\x7f\ud800-\udfff]", text) is None and text == text.strip()


@contextlib.contextmanager
def explained() -> Iterator[None]:
    """Turn an ``OSError`` inside the block, such as a full disk, into a ``UserError`` that names the file.

    For a part of a program that goes on after such a fault; others let ``OSError`` pass (``avs.system.faults``).

    Raises:
        UserError: the block raised ``OSError``.
    """
    try:
        yield
    except OSError as error:
        raise as_user_error(error) from error


def as_user_error(error: OSError) -> UserError:
    """Return the fault of the system in one line, with the file that it concerns and what to do."""
    fault = (error.strerror or str(error) or type(error).__name__).lower()
    remedy = _REMEDIES.get(error.errno or 0, "check the path and the disk, then run again")
    return UserError(error.filename or "a file", fault, remedy)


def _rename_in(error: OSError, temporary: Path, target: Path) -> None:
    """Let ``error`` name the result: a failed write() knows no name, other calls know the temporary one."""
    error.filename = str(error.filename or target).replace(str(temporary), str(target))
    error.filename2 = None


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
