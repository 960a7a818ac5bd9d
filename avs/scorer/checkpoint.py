"""A trained scorer on disk: one safetensors file whose header says which network it holds."""

from __future__ import annotations

import json
from pathlib import Path

import safetensors
import safetensors.torch
from pydantic import ValidationError

from avs.errors import UserError
from avs.files import atomic_path, canonical_json
from avs.scorer.network import CrossReferenceNetwork, build_network
from avs.scorer.settings import NetworkSettings

_FORMAT = "avs-cross-reference-1"
_REMEDY = "delete it and train the scorer again"


def save_network(path: Path, network: CrossReferenceNetwork) -> None:
    """Write the weights and the architecture to ``path``, whole or not at all; equal networks give equal bytes."""
    state = {key: value.detach().cpu().contiguous() for key, value in network.state_dict().items()}
    # safetensors keeps the entries of its header in no fixed order, hence a single one.
    header = {"network": canonical_json({"format": _FORMAT, "settings": network.settings.model_dump(mode="json")})}
    with atomic_path(path) as temporary:
        # save_file would put a file of its own there, readable by its owner alone
        temporary.write_bytes(safetensors.torch.save(state, metadata=header))


def load_network(path: Path) -> CrossReferenceNetwork:
    """Read a network that ``save_network`` wrote, in evaluation mode.

    Raises:
        UserError: the file is missing, truncated, not safetensors, not a scorer, or its weights do not fit its header.
    """
    try:
        with safetensors.safe_open(path, framework="pt") as file:
            metadata = file.metadata() or {}
            state = {key: file.get_tensor(key) for key in file.keys()}  # noqa: SIM118 (not a dictionary)
    except FileNotFoundError as error:
        raise UserError(path, "no such file", "train the scorer first") from error
    except (OSError, safetensors.SafetensorError) as error:
        raise UserError(path, f"not a readable safetensors file ({error})", _REMEDY) from error
    network = build_network(_settings(path, metadata), seed=0).eval()
    try:
        network.load_state_dict(state)
    except RuntimeError as error:
        first = [line.strip() for line in str(error).splitlines()][1:2]
        fault = f"its weights do not fit the architecture of its header ({''.join(first)[:120]})"
        raise UserError(path, fault, _REMEDY) from error
    return network


def _settings(path: Path, metadata: dict[str, str]) -> NetworkSettings:
    try:
        header = json.loads(metadata["network"])
        if header["format"] != _FORMAT:
            raise UserError(path, f"format {header['format']!r}, expected {_FORMAT!r}", _REMEDY)
        return NetworkSettings.model_validate(header["settings"])
    except (KeyError, TypeError, ValueError) as error:
        # pydantic's ValidationError is a ValueError too, of several lines
        first = error.errors()[0] if isinstance(error, ValidationError) else None
        detail = f"{'.'.join(map(str, first['loc']))}: {first['msg']}" if first else "its header is missing or damaged"
        raise UserError(path, f"not a scorer of this program ({detail})", _REMEDY) from error
