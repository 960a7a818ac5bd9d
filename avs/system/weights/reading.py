"""Reads weights as data: no pickle, so that a file from outside cannot run code."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from avs.system.errors import UserError


def read_torch(path: Path, remedy: str) -> Any:  # noqa: ANN401 - the caller checks what it gets
    """Return what ``torch.save`` put into a file: tensors in dictionaries and tuples.

    Args:
        path: the file.
        remedy: what the user can do if the file is bad.

    Raises:
        UserError: the file is truncated, or holds objects that only pickle could make.
    """
    import pickle

    import torch

    try:
        return torch.load(path, map_location="cpu", weights_only=True)
    except pickle.UnpicklingError as error:
        fault = "holds objects that would run code when they are loaded, or is damaged"
        raise UserError(path, fault, remedy) from error
    except Exception as error:  # torch raises many types for a damaged file
        reason = " ".join(str(error).split())[:100] or type(error).__name__
        raise UserError(path, f"cannot be read as weights ({reason})", remedy) from error


def read_state(path: Path, remedy: str) -> dict[str, Any]:
    """Return the state dictionary of a checkpoint, by parameter name.

    A wrapper ``params`` or ``state_dict`` and the prefix ``module.`` of parallel training are taken off.

    Raises:
        UserError: see ``read_torch``; or there is no state dictionary in it.
    """
    import torch

    values = read_torch(path, remedy)
    for wrapper in ("params", "state_dict"):
        if isinstance(values, dict) and isinstance(values.get(wrapper), dict):
            values = values[wrapper]
    if not isinstance(values, dict) or not all(isinstance(value, torch.Tensor) for value in values.values()):
        raise UserError(path, "holds no dictionary of tensors", remedy)
    return {str(name).removeprefix("module."): value for name, value in values.items()}


def read_fault(path: Path) -> str | None:
    """Return why a file of weights cannot be read as data, or None; the suffix tells the format."""
    try:
        if path.suffix == ".safetensors":
            import safetensors

            with safetensors.safe_open(path, "pt"):
                return None
        if path.suffix == ".mat":
            import scipy.io

            scipy.io.loadmat(path)
            return None
        read_torch(path, "")
    except UserError as error:
        return str(error).removeprefix(f"{path}: ").removesuffix("; ")
    except Exception as error:  # scipy and safetensors raise many types for a damaged file
        return f"cannot be read as weights ({' '.join(str(error).split())[:100]})"
    return None
