"""A trained scorer on disk: a safetensors file whose header says which network it holds; or CrossScore's checkpoint."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch
from pydantic import TypeAdapter, ValidationError

from avs.iqa.cross_reference.crossscore import is_archive, read_crossscore
from avs.iqa.cross_reference.network import CrossReferenceNetwork, build_network
from avs.iqa.cross_reference.scorer_settings import AnyNetwork
from avs.iqa.cross_reference.training_facts import TrainingFacts
from avs.system.errors import UserError
from avs.system.models import first_fault
from avs.system.tensor_files import read_tensors, write_tensors
from avs.system.weights.cache import damage, find

_FORMAT = "avs-cross-reference-1"
_HEADER = "network"
_NETWORK: TypeAdapter[AnyNetwork] = TypeAdapter(AnyNetwork)
_REMEDY = "delete it and train the scorer again"


def save_network(path: Path, network: CrossReferenceNetwork, training: TrainingFacts | None = None) -> None:
    """Write the weights, the architecture and what is known of the training to ``path``, whole or not at all.

    Equal networks give equal bytes.
    """
    state = {key: value.detach().cpu().numpy() for key, value in network.state_dict().items()}
    told = None if training is None else training.model_dump(mode="json")
    header = {"format": _FORMAT, "settings": network.settings.model_dump(mode="json"), "training": told}
    write_tensors(path, state, _HEADER, header)


def load_network(path: Path, backbone: str | None = None) -> CrossReferenceNetwork:
    """Read a network that ``save_network`` wrote, or CrossScore's published checkpoint, in evaluation mode.

    Args:
        path: the file; its first bytes tell which of the two it is.
        backbone: refuse a network on another backbone than this.

    Raises:
        UserError: the file is missing, truncated, a pickle, or not a scorer; its weights do not fit its header; it is a
            checkpoint that has not the published one's hash; or its backbone is not the one asked for.
    """
    try:
        network = _read_published(path) if is_archive(path) else _read(path)
    except FileNotFoundError as error:
        raise UserError(path, "no such file", "train the scorer first") from error
    if backbone not in (None, network.settings.backbone):
        fault = f"holds a network on {network.settings.backbone}, where {backbone} is needed"
        raise UserError(path, fault, "pass the weights of the scorer that the method names")
    return network


def read_training(path: Path) -> TrainingFacts | None:
    """Return what a file of ``save_network`` tells of the training, or None if it tells nothing.

    Raises:
        UserError: its header is damaged.
    """
    told = read_tensors(path, _HEADER, _REMEDY)[1].get("training")
    try:
        return None if told is None else TrainingFacts.model_validate(told)
    except ValueError as error:
        raise UserError(path, "its header does not tell of its training as it should", _REMEDY) from error


def _read_published(path: Path) -> CrossReferenceNetwork:
    """Read CrossScore's checkpoint, once its length and hash are found to be the published ones."""
    fault = damage(find("crossscore"), path)
    if fault is not None:
        raise UserError(path, f"not CrossScore's published checkpoint ({fault})", "run: avs weights fetch crossscore")
    return read_crossscore(path)


def _read(path: Path) -> CrossReferenceNetwork:
    """Read what ``save_network`` wrote."""
    arrays, header = read_tensors(path, _HEADER, _REMEDY)
    state = {name: torch.from_numpy(array) for name, array in arrays.items()}
    network = build_network(_settings(path, header), seed=0).eval()
    try:
        network.load_state_dict(state)
    except RuntimeError as error:
        first = [line.strip() for line in str(error).splitlines()][1:2]
        fault = f"its weights do not fit the architecture of its header ({''.join(first)[:120]})"
        raise UserError(path, fault, _REMEDY) from error
    return network


def _settings(path: Path, header: dict[str, Any]) -> AnyNetwork:
    try:
        if header["format"] != _FORMAT:
            raise UserError(path, f"format {header['format']!r}, expected {_FORMAT!r}", _REMEDY)
        return _NETWORK.validate_python(header["settings"])
    except (KeyError, ValueError) as error:
        # pydantic's ValidationError is a ValueError too, of several lines
        damaged = "its header is missing or damaged"
        detail = ": ".join(filter(None, first_fault(error))) if isinstance(error, ValidationError) else damaged
        raise UserError(path, f"not a scorer of this program ({detail})", _REMEDY) from error
