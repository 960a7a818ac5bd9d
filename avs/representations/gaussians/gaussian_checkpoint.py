"""Checkpoints: tensors and a JSON state in one safetensors file. Reading one runs no code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from torch import Tensor

from avs.representations.gaussians.gaussian_settings import GaussianSettings
from avs.representations.state_files import read_state, write_state
from avs.scene.similarity import Similarity
from avs.system.models import StrictModel

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
    write_state(path, tensors, _HEADER, state)


def read_checkpoint(path: Path) -> tuple[dict[str, Tensor], CheckpointState]:
    """Return the tensors, on the CPU, and the state that ``write_checkpoint`` wrote.

    Raises:
        UserError: the file is missing, damaged, or not a checkpoint of Gaussians.
    """
    remedy = "give the path of a checkpoint of Gaussians, or fit again"
    return read_state(path, _HEADER, CheckpointState, "is not a checkpoint of Gaussians", remedy)
