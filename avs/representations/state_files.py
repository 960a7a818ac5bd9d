"""Tensors and a typed state in one safetensors file, as checkpoints have them. Reading one runs no code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

import torch
from pydantic import BaseModel, ValidationError
from torch import Tensor

from avs.system.errors import UserError
from avs.system.models import first_fault
from avs.system.tensor_files import read_tensors, write_tensors

State = TypeVar("State", bound=BaseModel)


def write_state(path: Path, tensors: Mapping[str, Tensor], header: str, state: BaseModel) -> None:
    """Write ``tensors``, and ``state`` in the header of that name, to ``path`` atomically."""
    arrays = {name: tensor.detach().cpu().numpy() for name, tensor in tensors.items()}
    write_tensors(path, arrays, header, state.model_dump(mode="json"))


def read_state(path: Path, header: str, kind: type[State], fault: str, remedy: str) -> tuple[dict[str, Tensor], State]:
    """Return the tensors, on the CPU, and the state that ``write_state`` wrote.

    Raises:
        UserError: the file is missing, damaged, or holds no state of this kind; then ``fault`` tells so.
    """
    arrays, found = read_tensors(path, header, remedy)
    try:
        state = kind.model_validate(found)
    except ValidationError as error:
        raise UserError(path, f"{fault} ({first_fault(error)[1]})", remedy) from error
    return {name: torch.from_numpy(array) for name, array in arrays.items()}, state
