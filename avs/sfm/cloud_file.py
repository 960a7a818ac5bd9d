"""Clouds as PLY files that any viewer opens, with further numbers for each point, a digest, and no other dependency."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from avs.sfm.cloud import Cloud
from avs.system.digests import UNKNOWN, is_sealed, sealed
from avs.system.errors import UserError
from avs.system.files import atomic_path

FloatFields = Mapping[str, npt.NDArray[np.float32]]

_FIRST = ("x", "y", "z", "red", "green", "blue", "confidence")
_WORDS = {"<f4": "float", "|u1": "uchar"}
_TYPES = {word: code for code, word in _WORDS.items()}
_LONGEST = 4096
"""Bytes of a header, at most."""


def write_cloud(path: Path, cloud: Cloud, fields: FloatFields | None = None) -> None:
    """Write a cloud, whole or not at all; equal content gives equal bytes.

    Positions are rounded to float32, which every viewer reads: in a scene's own unit that is 1e-7 of its extent.

    Args:
        path: a ``.ply`` file; what was there is replaced.
        cloud: the points.
        fields: further numbers ``[n]`` of each point by name, such as ``distance``.

    Raises:
        ValueError: a field has another length than the cloud, or the name of one that is there.
    """
    extra = dict(fields or {})
    for name, values in extra.items():
        if name in _FIRST or not name.isidentifier() or values.shape != (len(cloud),):
            raise ValueError(f"field {name!r} of shape {values.shape} does not fit a cloud of {len(cloud)} points")
    kinds = [(name, "|u1" if name in ("red", "green", "blue") else "<f4") for name in (*_FIRST, *extra)]
    rows = np.empty(len(cloud), dtype=kinds)
    for names, table in (("x y z", cloud.positions), ("red green blue", cloud.colors)):
        for name, column in zip(names.split(), table.T, strict=True):
            rows[name] = column
    for name, values in {"confidence": cloud.confidence, **extra}.items():
        rows[name] = values
    lines = [f"property {_WORDS[kind]} {name}" for name, kind in kinds]
    content = _header(UNKNOWN, len(cloud), lines).encode() + rows.tobytes()
    with atomic_path(path) as temporary:
        temporary.write_bytes(sealed(content))


def read_cloud(path: Path, remedy: str) -> tuple[Cloud, dict[str, npt.NDArray[np.float32]]]:
    """Return the cloud and the further fields that ``write_cloud`` wrote.

    Args:
        path: the file.
        remedy: what to do about a file that is damaged.

    Raises:
        UserError: the file is missing, is not one of ``write_cloud``, or is not as it was written.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        fault = (error.strerror or "cannot be read").lower()
        raise UserError(path, fault, "run the job that makes it again") from error
    header, mark, _ = content[:_LONGEST].partition(b"end_header\n")
    lines = header.decode("ascii", errors="replace").splitlines()
    if not mark or len(lines) < 4 or lines[0] != "ply" or not lines[2].startswith("comment digest "):
        raise UserError(path, "is no cloud of this suite", remedy)
    if not is_sealed(content, lines[2].removeprefix("comment digest ")):
        raise UserError(path, "was changed after it was written", remedy)
    words = [line.split() for line in lines[4:]]
    kinds = [(name, _TYPES[kind]) for _, kind, name in words]
    rows = np.frombuffer(content, dtype=kinds, offset=len(header) + len(mark))
    cloud = Cloud(
        np.stack([rows[axis] for axis in "xyz"], axis=1).astype(np.float64),
        np.stack([rows[color] for color in ("red", "green", "blue")], axis=1),
        rows["confidence"].copy(),
    )
    return cloud, {name: rows[name].copy() for name, _ in kinds[len(_FIRST) :]}


def _header(digest: str, count: int, properties: list[str]) -> str:
    lines = ["ply", "format binary_little_endian 1.0", f"comment digest {digest}", f"element vertex {count}"]
    return "\n".join([*lines, *properties, "end_header", ""])
