"""Checkpoints of radiance fields: tensors and a JSON state in one safetensors file. Reading one runs no code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from torch import Tensor

from avs.representations.state_files import read_state, write_state
from avs.scene.similarity import Similarity
from avs.system.models import StrictModel

_HEADER = "radiance_field"


class FieldState(StrictModel):
    """Everything but tensors that further steps depend on."""

    version: Literal[1] = 1
    settings: dict[str, Any]
    radius: float
    to_capture: Similarity
    iteration: int
    adam_steps: dict[str, int]
    photographs: list[str]
    generator: dict[str, Any]


def write_field(path: Path, tensors: Mapping[str, Tensor], state: FieldState) -> None:
    """Write ``tensors`` and ``state`` to ``path`` atomically."""
    write_state(path, tensors, _HEADER, state)


def read_field(path: Path) -> tuple[dict[str, Tensor], FieldState]:
    """Return the tensors, on the CPU, and the state that ``write_field`` wrote.

    Raises:
        UserError: the file is missing, damaged, or no checkpoint of a radiance field.
    """
    remedy = "give the path of a checkpoint of this kind of representation, or fit again"
    return read_state(path, _HEADER, FieldState, "is no checkpoint of a radiance field", remedy)
