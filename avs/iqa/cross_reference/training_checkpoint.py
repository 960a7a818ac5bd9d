"""A training on disk while it runs, so that a killed one goes on from its last checkpoint to the same bits."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path
from typing import Any

import torch

from avs.iqa.cross_reference.training_run import LossPoint, TrainingRun
from avs.system.errors import UserError
from avs.system.tensor_files import read_tensors, write_tensors

_HEADER = "training"
_NETWORK, _OPTIMIZER = "network", "optimizer"


def save_training(path: Path, run: TrainingRun, made_of: str) -> None:
    """Write a checkpoint atomically; ``made_of`` names the data, the settings and the code."""
    tensors = {f"{_NETWORK}.{name}": tensor for name, tensor in run.network.state_dict().items()}
    for index, moments in run.optimizer.state_dict()["state"].items():
        tensors |= {f"{_OPTIMIZER}.{index}.{name}": tensor for name, tensor in moments.items()}
    values = {
        "made_of": made_of,
        "step": run.step,
        "recent": run.recent,
        "curve": [list(astuple(point)) for point in run.curve],
        "draws": run.sampler.state,
    }
    write_tensors(path, {name: tensor.detach().cpu().numpy() for name, tensor in tensors.items()}, _HEADER, values)


def load_training(path: Path, run: TrainingRun, made_of: str) -> str | None:
    """Put a training that has not begun into the state of a checkpoint, if there is one to go on from.

    Returns:
        What a reader should know of it, one line; None if there is no checkpoint.
    """
    if not path.is_file():
        return None
    try:
        arrays, values = read_tensors(path, _HEADER, "delete it")
    except UserError as error:
        return f"begun anew: {error}"
    if values["made_of"] != made_of:
        return f"begun anew: {path} is of other data, settings or code"
    tensors = {name: torch.from_numpy(array) for name, array in arrays.items()}
    run.network.load_state_dict(_under(_NETWORK, tensors))
    moments: dict[int, dict[str, Any]] = {}
    for name, tensor in _under(_OPTIMIZER, tensors).items():
        index, kind = name.split(".", 1)
        moments.setdefault(int(index), {})[kind] = tensor
    run.optimizer.load_state_dict({**run.optimizer.state_dict(), "state": moments})
    run.sampler.state = values["draws"]
    run.step, run.recent = values["step"], values["recent"]
    run.curve = [LossPoint(*point) for point in values["curve"]]
    return f"goes on from step {run.step} of {path}"


def _under(group: str, tensors: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    return {name.removeprefix(f"{group}."): each for name, each in tensors.items() if name.startswith(f"{group}.")}
