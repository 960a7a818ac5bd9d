"""Archives from outside, unpacked inside of one folder and nowhere else, whole or not at all."""

from __future__ import annotations

import lzma
import os
import shutil
import struct
import tarfile
import zipfile
import zlib
from collections.abc import Collection, Iterator
from contextlib import AbstractContextManager
from pathlib import Path, PurePosixPath
from typing import IO, cast

from avs.system.errors import UserError
from avs.system.files import atomic_folder, file_hash

_COPY = "get the archive again"
_ELSEWHERE = "unpack it with a program that can, and take the folder"
_TRUST = "do not use it: no archive of a data set has such a member"
_LINK = 0o120000
_KIND = 0o170000
_ENCRYPTED = 1
_ZIP = (b"PK\x03\x04", b"PK\x05\x06")
"""What a ZIP archive begins with; its end proves nothing, since the last member of a tar may be a ZIP archive."""
_DAMAGE = (
    zipfile.BadZipFile,
    tarfile.TarError,
    zlib.error,
    lzma.LZMAError,
    EOFError,
    struct.error,
    ValueError,
    OverflowError,
)
"""What the libraries raise of archives whose bytes make no sense."""


_Member = tuple[PurePosixPath, int, AbstractContextManager[IO[bytes]]]


def unpack(archive: Path, folder: Path, sha256: str | None = None, kept: Collection[str] = ()) -> list[str]:
    """Unpack a ZIP or tar archive into ``folder``, beside what is there, and return the names at the top of it.

    Nothing in ``folder`` is replaced. Every member is checked by the archive's own checksum, where it has one.

    Args:
        archive: the file.
        folder: is made if need be.
        sha256: of the file, in hexadecimal, if it is known.
        kept: names in ``folder`` that stay as they are, though the archive holds them.

    Raises:
        UserError: the archive is missing, damaged, cut off or none, or another than ``sha256`` says; a member would
            leave the folder, is a link or a device, or is encrypted or compressed in a way that cannot be read; there
            is no room for it; or something of its name is there.
    """
    if not archive.is_file():
        raise UserError(archive, "there is no such archive", "give the file that was downloaded")
    if sha256 is not None and file_hash(archive) != sha256.lower():
        raise UserError(archive, "has another SHA-256 than the one given", _COPY)
    folder.mkdir(parents=True, exist_ok=True)
    try:
        with atomic_folder(folder / f"{archive.name}.unpacked") as temporary:
            for name, size, stream in _members(archive, folder):
                target = temporary / name
                target.parent.mkdir(parents=True, exist_ok=True)
                with stream as source, open(target, "xb") as sink:
                    shutil.copyfileobj(source, sink)
                if target.stat().st_size != size:
                    raise UserError(archive, f"{name} is cut off", _COPY)
    except NotImplementedError as error:
        raise UserError(archive, f"cannot be read here ({_line(error)})", _ELSEWHERE) from error
    except _DAMAGE as error:
        raise UserError(archive, f"is damaged or cut off ({_line(error)})", _COPY) from error
    except FileExistsError as error:
        raise UserError(archive, "has a member twice", _COPY) from error
    except OSError as error:
        if error.errno is not None:
            raise
        # gzip and bz2 say so of damaged data, without a number of the system's
        raise UserError(archive, f"is damaged or cut off ({error.args[0]})", _COPY) from error
    return _moved(archive, folder / f"{archive.name}.unpacked", folder, kept)


def _members(archive: Path, folder: Path) -> Iterator[_Member]:
    """Yield path, size and content of each file in the archive, after a look at all of them."""
    with open(archive, "rb") as stream:
        first = stream.read(len(_ZIP[0]))
    if first in _ZIP:
        yield from _zipped(archive, folder)
    elif tarfile.is_tarfile(archive):
        yield from _tarred(archive, folder)
    else:
        raise UserError(archive, "is no ZIP or tar archive, or is cut off", _COPY)


def _zipped(archive: Path, folder: Path) -> Iterator[_Member]:
    with zipfile.ZipFile(archive) as zipped:
        if min((entry.header_offset for entry in zipped.infolist()), default=0):
            raise UserError(archive, "has something before its first member, as two archives in one file", _COPY)
        entries = [entry for entry in zipped.infolist() if not entry.is_dir()]
        for entry in entries:
            linked = entry.external_attr >> 16 & _KIND == _LINK
            _check(archive, entry.filename, not linked)
            if entry.flag_bits & _ENCRYPTED:
                raise UserError(archive, f"its member {entry.filename} is encrypted", _ELSEWHERE)
        _check_room(archive, folder, sum(entry.file_size for entry in entries))
        for entry in entries:
            yield PurePosixPath(entry.filename), entry.file_size, zipped.open(entry)


def _tarred(archive: Path, folder: Path) -> Iterator[_Member]:
    with tarfile.open(archive) as tarred:
        members = [member for member in tarred.getmembers() if not member.isdir()]
        for member in members:
            _check(archive, member.name, member.isreg())
        _check_room(archive, folder, sum(member.size for member in members))
        for member in members:
            yield PurePosixPath(member.name), member.size, cast(IO[bytes], tarred.extractfile(member))
        _check_end(archive, tarred)


def _check_end(archive: Path, tarred: tarfile.TarFile) -> None:
    """See that a block of zeros follows the last member, and nothing but zeros.

    ``tarfile`` ends in silence where the file does, or where a header makes no sense: the members after that are lost.
    To read up to the end also compares the checksum of a compressed tar.
    """
    stream = cast(IO[bytes], tarred.fileobj)
    stream.seek(tarred.offset)
    rest = stream.read(tarfile.BLOCKSIZE)
    if len(rest) < tarfile.BLOCKSIZE:
        raise UserError(archive, "is cut off: it lacks the mark of its end", _COPY)
    while rest:
        if rest.strip(b"\0"):
            fault = "is damaged, or two archives in one file: something other than members follows the last one"
            raise UserError(archive, fault, _COPY)
        rest = stream.read(1 << 20)


def _line(error: Exception) -> str:
    return " ".join(str(error).split())


def _check(archive: Path, name: str, is_file: bool) -> None:
    path = PurePosixPath(name.replace("\\", "/"))
    if path.is_absolute() or ".." in path.parts or not path.parts or ":" in path.parts[0] or "\0" in name:
        raise UserError(archive, f"its member {name} would leave the folder", _TRUST)
    if not is_file:
        raise UserError(archive, f"its member {name} is a link or a device", _TRUST)


def _check_room(archive: Path, folder: Path, size: int) -> None:
    free = shutil.disk_usage(folder).free
    if size > free:
        fault = f"needs {size / 1e9:.1f} GB, but {free / 1e9:.1f} GB are free in {folder}"
        raise UserError(archive, fault, "free some space, or choose another folder")


def _moved(archive: Path, unpacked: Path, folder: Path, kept: Collection[str]) -> list[str]:
    """Move what was unpacked into ``folder``, unless something of one of the names is there that is not to be kept."""
    names = sorted(path.name for path in unpacked.iterdir())
    new = [name for name in names if name not in kept]
    there = [name for name in new if (folder / name).exists()]
    if there:
        shutil.rmtree(unpacked)
        raise UserError(folder / there[0], f"is there already, and {archive.name} holds it", "take it away first")
    for name in new:
        os.replace(unpacked / name, folder / name)
    shutil.rmtree(unpacked)
    return names
