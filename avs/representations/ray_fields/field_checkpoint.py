"""Checkpoints of radiance fields: tensors and a JSON state in one safetensors file. Reading one runs no code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import torch
from pydantic import ValidationError
from torch import Tensor

from avs.scene.similarity import Similarity
from avs.system.errors import UserError
from avs.system.models import StrictModel, first_fault
from avs.system.tensor_files import read_tensors, write_tensors

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
    arrays = {name: tensor.detach().cpu().numpy() for name, tensor in tensors.items()}
    write_tensors(path, arrays, _HEADER, state.model_dump(mode="json"))


def read_field(path: Path) -> tuple[dict[str, Tensor], FieldState]:
    """Return the tensors, on the CPU, and the state that ``write_field`` wrote.

    Raises:
        UserError: the file is missing, damaged, or no checkpoint of a radiance field.
    """
    remedy = "give the path of a checkpoint of this kind of representation, or fit again"
    arrays, header = read_tensors(path, _HEADER, remedy)
    try:
        state = FieldState.model_validate(header)
    except ValidationError as error:
        raise UserError(path, f"is no checkpoint of a radiance field ({first_fault(error)[1]})", remedy) from error
    return {name: torch.from_numpy(array) for name, array in arrays.items()}, state
