"""Arrays with a header in one safetensors file, whole or not at all. Reading one runs no code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import safetensors.numpy

from avs.system.files import atomic_path, canonical_json


def write_tensors(path: Path, arrays: Mapping[str, npt.NDArray[Any]], header: str, values: object) -> None:
    """Write ``arrays`` by name to ``path``, with one metadata entry; equal content gives equal bytes.

    Args:
        path: the file; what was there is replaced.
        arrays: arrays of any shape, of a type that safetensors knows.
        header: name of the metadata entry. There is only one, because safetensors keeps entries in no fixed order.
        values: its content, which becomes canonical JSON.
    """
    contiguous = {name: np.asarray(array, order="C") for name, array in arrays.items()}
    content = safetensors.numpy.save(contiguous, metadata={header: canonical_json(values)})
    with atomic_path(path) as temporary:
        # safetensors' save_file would put a file of its own there, readable by its owner alone
        temporary.write_bytes(content)
