"""Arrays with a header in one safetensors file, whole or not at all, with a digest. Reading one runs no code."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import safetensors
import safetensors.numpy

from avs.system.digests import UNKNOWN, is_sealed, sealed
from avs.system.errors import UserError
from avs.system.files import atomic_path, canonical_json

_DIGEST = "digest"


def write_tensors(path: Path, arrays: Mapping[str, npt.NDArray[Any]], header: str, values: Mapping[str, Any]) -> None:
    """Write ``arrays`` by name to ``path``, with one metadata entry; equal content gives equal bytes.

    Args:
        path: the file; what was there is replaced.
        arrays: arrays of any shape, of a type that safetensors and numpy know.
        header: name of the metadata entry. There is only one, because safetensors keeps entries in no fixed order.
        values: its content, which becomes canonical JSON, and gets the file's SHA-256 as ``digest``.
    """
    contiguous = {name: np.asarray(array, order="C") for name, array in arrays.items()}
    metadata = {header: canonical_json({**values, _DIGEST: UNKNOWN})}
    content = safetensors.numpy.save(contiguous, metadata=metadata)
    with atomic_path(path) as temporary:
        # safetensors' save_file would put a file of its own there, readable by its owner alone
        temporary.write_bytes(sealed(content))


def read_tensors(path: Path, header: str, remedy: str) -> tuple[dict[str, npt.NDArray[Any]], dict[str, Any]]:
    """Return the arrays and the header that ``write_tensors`` wrote.

    Args:
        path: the file.
        header: name of the metadata entry.
        remedy: what to do about a file that is damaged.

    Raises:
        UserError: the file is missing, is no safetensors, has no such header, or is not as it was written.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        fault = (error.strerror or "cannot be read").lower()
        raise UserError(path, fault, "run the job that makes it again") from error
    try:
        arrays = safetensors.numpy.load(content)
    except (safetensors.SafetensorError, ValueError, KeyError, TypeError) as error:
        raise UserError(path, f"not a readable safetensors file ({error})", remedy) from error
    values = _header(path, content, header, remedy)
    if not is_sealed(content, str(values.pop(_DIGEST, None))):
        raise UserError(path, "was changed after it was written", remedy)
    return arrays, values


def _header(path: Path, content: bytes, header: str, remedy: str) -> dict[str, Any]:
    """Return the metadata entry ``header`` of a file that safetensors has read."""
    length = int.from_bytes(content[:8], "little")
    try:
        values = json.loads(json.loads(content[8 : 8 + length])["__metadata__"][header])
        if isinstance(values, dict):
            return values
    except (KeyError, TypeError, ValueError):
        pass
    raise UserError(path, f"its header has no entry {header}: it is not what was to be read", remedy)
