"""Checkpoints: tensors and a JSON state in one safetensors file. Reading one runs no code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import torch
from pydantic import ValidationError
from torch import Tensor

from avs.representations.gaussians.gaussian_settings import GaussianSettings
from avs.scene.similarity import Similarity
from avs.system.errors import UserError
from avs.system.models import StrictModel, first_fault
from avs.system.tensor_files import read_tensors, write_tensors

_HEADER = "state"


class CheckpointState(StrictModel):
    """Everything but tensors that further steps depend on."""

    version: Literal[2] = 2
    settings: GaussianSettings
    extent: float
    to_capture: Similarity
    iteration: int
    adam_steps: dict[str, int]
    queue: list[int]
    view_count: int
    generator: dict[str, Any]


def write_checkpoint(path: Path, tensors: Mapping[str, Tensor], state: CheckpointState) -> None:
    """Write ``tensors`` and ``state`` to ``path`` atomically."""
    arrays = {name: tensor.detach().cpu().numpy() for name, tensor in tensors.items()}
    write_tensors(path, arrays, _HEADER, state.model_dump(mode="json"))


def read_checkpoint(path: Path) -> tuple[dict[str, Tensor], CheckpointState]:
    """Return the tensors, on the CPU, and the state that ``write_checkpoint`` wrote.

    Raises:
        UserError: the file is missing, damaged, or not a checkpoint of Gaussians.
    """
    remedy = "give the path of a checkpoint of Gaussians, or fit again"
    arrays, header = read_tensors(path, _HEADER, remedy)
    try:
        state = CheckpointState.model_validate(header)
    except ValidationError as error:
        raise UserError(path, f"is not a checkpoint of Gaussians ({first_fault(error)[1]})", remedy) from error
    return {name: torch.from_numpy(array) for name, array in arrays.items()}, state
