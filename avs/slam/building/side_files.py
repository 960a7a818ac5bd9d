"""Files that a mesh file names: buffers and textures of ``.gltf``, materials and their textures of ``.obj``."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from avs.system.files import file_hash

_HEAD = 1 << 20
"""Bytes of an ``.obj`` file in which its materials are looked for; they are named before the surfaces."""


def side_files(path: Path) -> list[Path]:
    """Return the files that are there of those which a mesh file names, in order and once each.

    A file that cannot be understood names none: whoever reads the mesh tells of its fault.
    """
    found = {".gltf": _of_gltf, ".obj": _of_obj}.get(path.suffix.lower())
    if found is None or not path.is_file():
        return []
    return [each for each in dict.fromkeys(found(path)) if each.is_file()]


def mesh_digest(path: Path) -> str:
    """Return the SHA-256 of a mesh file; where it names others, that of its own and theirs."""
    others = side_files(path)
    if not others:
        return file_hash(path)
    return hashlib.sha256(" ".join(map(file_hash, [path, *others])).encode()).hexdigest()


def _of_gltf(path: Path) -> Iterator[Path]:
    try:
        described = json.loads(path.read_bytes())
        entries = [*described.get("buffers", []), *described.get("images", [])]
        names = [entry["uri"] for entry in entries if "uri" in entry]
    except (ValueError, AttributeError, TypeError, KeyError):
        return
    for name in names:
        if isinstance(name, str) and not name.startswith("data:"):
            yield path.parent / unquote(name)


def _of_obj(path: Path) -> Iterator[Path]:
    with path.open("rb") as stream:
        lines = stream.read(_HEAD).decode(errors="replace").splitlines()
    for line in lines:
        word, _, name = line.strip().partition(" ")
        if word == "mtllib":
            material = path.parent / name.strip()
            yield material
            for told in material.read_text(errors="replace").splitlines() if material.is_file() else []:
                kind, _, options = told.strip().partition(" ")
                if kind.lower().startswith("map_") and options.split():
                    yield material.parent / options.split()[-1]
