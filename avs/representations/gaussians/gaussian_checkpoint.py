"""Checkpoints: tensors and a JSON state in one safetensors file. Reading one runs no code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationError
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import Tensor

from avs.representations.gaussians.gaussian_settings import GaussianSettings
from avs.scene.similarity import Similarity
from avs.system.errors import UserError
from avs.system.files import atomic_path, canonical_json
from avs.system.models import StrictModel, first_fault


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
    # One metadata entry: safetensors keeps them in a hash map, whose order differs from run to run.
    metadata = {"state": canonical_json(state.model_dump(mode="json"))}
    arrays = {name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()}
    with atomic_path(path) as temporary:
        save_file(arrays, temporary, metadata=metadata)


def read_checkpoint(path: Path) -> tuple[dict[str, Tensor], CheckpointState]:
    """Return the tensors, on the CPU, and the state that ``write_checkpoint`` wrote.

    Raises:
        UserError: the file is missing, damaged, or not a checkpoint of Gaussians.
    """
    remedy = "give the path of a checkpoint of Gaussians, or fit again"
    try:
        with safe_open(path, framework="pt") as stream:
            state = CheckpointState.model_validate_json((stream.metadata() or {}).get("state", "{}"))
            tensors = {name: stream.get_tensor(name) for name in stream.keys()}  # noqa: SIM118 (no mapping)
    except (OSError, SafetensorError) as error:
        raise UserError(path, f"cannot be read as safetensors ({error})", remedy) from error
    except ValidationError as error:
        raise UserError(path, f"is not a checkpoint of Gaussians ({first_fault(error)[1]})", remedy) from error
    return tensors, state
