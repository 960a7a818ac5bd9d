"""Files that a mesh file names: buffers and textures of glTF files, materials and their textures of ``.obj``."""

from __future__ import annotations

import hashlib
import json
import mmap
import re
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path, PureWindowsPath
from urllib.parse import unquote

from avs.system.files import file_hash

_MOST_WORDS = 24
"""Of a line of materials; longer ones name no file."""


def side_files(path: Path) -> list[Path]:
    """Return the files that are there of those which a mesh file may name, in order and once each.

    Readers disagree about names with blanks, options before names and several names in one line, so that of all words
    and runs of words those count that are names of files: one more is hashed in vain, one less would go unseen. A file
    that cannot be understood names none: whoever reads the mesh tells of its fault.
    """
    kinds = {".gltf": _of_gltf, ".glb": _of_gltf, ".obj": _of_obj}
    found = kinds.get(path.suffix.lower())
    if found is None or not path.is_file():
        return []
    return [each for each in dict.fromkeys(found(path)) if each != path and each.is_file()]


def mesh_digest(path: Path) -> str:
    """Return the SHA-256 of a mesh file; where it names others, that of its own and theirs."""
    others = side_files(path)
    if not others:
        return file_hash(path)
    return hashlib.sha256(" ".join(map(file_hash, [path, *others])).encode()).hexdigest()


def _of_gltf(path: Path) -> Iterator[Path]:
    try:
        described = json.loads(gltf_description(path))
        entries = [*described.get("buffers", []), *described.get("images", [])]
        names = [entry["uri"] for entry in entries if "uri" in entry]
    except (ValueError, AttributeError, TypeError, KeyError, struct.error):
        return
    for name in names:
        if isinstance(name, str) and not name.startswith("data:") and "\0" not in name:
            yield path.parent / unquote(name)


def gltf_description(path: Path) -> bytes:
    """Return what a glTF file says in JSON; of a binary one it is the first chunk.

    Raises:
        struct.error: a binary one ends before it.
    """
    if path.suffix.lower() != ".glb":
        return path.read_bytes()
    with path.open("rb") as stream:
        (length,) = struct.unpack("<I", stream.read(20)[12:16])
        return stream.read(length)


def _of_obj(path: Path) -> Iterator[Path]:
    for library in libraries_of(path):
        yield library
        for line in library.read_text(errors="replace").splitlines():
            if not _is_numeric(line):
                yield from places_of_line(line, [library.parent, path.parent])


def libraries_of(path: Path) -> list[Path]:
    """Return the files of materials of an ``.obj`` file that are there: those that it may name, and its own."""
    own = path.with_suffix(".mtl")  # taken where the named one is not there
    named = [each for line in statements(path, "mtllib") for each in places_of_line(line, [path.parent])]
    return [each for each in dict.fromkeys([*named, own]) if each.is_file()]


def places_of_line(line: str, folders: Sequence[Path]) -> Iterator[Path]:
    """Yield where the files may lie that a line names: each word of it, and all that stands from one to another."""
    for name in _runs_of_words(line):
        for folder in folders:
            yield from _places(name, folder)


def statements(path: Path, word: str) -> Iterator[str]:
    """Yield what follows each statement of a word, such as ``mtllib``, in an ``.obj`` file, wherever it stands."""
    if not path.stat().st_size:
        return
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content:
        for found in re.finditer(rb"^[ \t]*" + word.encode() + rb"\b([^\r\n]*)", content, re.MULTILINE):
            yield found[1].decode(errors="replace")


def _runs_of_words(line: str) -> Iterator[str]:
    """Yield each word of a line, and all that stands from one to another."""
    spans = [found.span() for found in re.finditer(r"\S+", line)]
    if len(spans) <= _MOST_WORDS:
        for place, (start, _) in enumerate(spans):
            yield from (line[start:end].strip("\"'\0") for _, end in spans[place:])


def _is_numeric(line: str) -> bool:
    """Return whether all that follows the first word are numbers, as of a colour."""
    return all(re.fullmatch(r"[-+.0-9eE]+", word) for word in line.split()[1:])


def _places(name: str, folder: Path) -> Iterator[Path]:
    """Yield where a file of this name may lie: as it is written, with slashes, or in the folder itself."""
    if "\0" in name or len(name.encode(errors="replace")) > 255:
        return
    told = PureWindowsPath(name)
    for each in dict.fromkeys([name, told.as_posix(), told.name]):
        if each:
            yield folder / each
