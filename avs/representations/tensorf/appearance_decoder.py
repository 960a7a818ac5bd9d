"""From appearance features and viewing directions to colours: a small network, or spherical harmonics."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import torch
from torch import Tensor

from avs.representations.tensorf.tensorf_settings import TensorfSettings

FEATURES = 27
"""Width of the appearance (arXiv 2203.09517, section 5), and as many as nine harmonics of three channels are."""


def decoder_tensors(settings: TensorfSettings, generator: np.random.Generator) -> dict[str, Tensor]:
    """Return the untrained tensors of the decoder by name.

    ``basis`` ``[3 * components, 27]`` is the matrix that makes features of products. Layers of the network are
    ``[inputs, outputs]``, drawn as torch's linear layers are; the last bias is 0, as in the public code.
    """
    tensors = {"basis": _linear(generator, 3 * settings.appearance_components, FEATURES)}
    if settings.decoder == "sh":
        return tensors
    inputs = (FEATURES + 3) * (1 + 2 * settings.frequencies)
    for number, (width, outputs) in enumerate(
        ((inputs, settings.hidden), (settings.hidden, settings.hidden), (settings.hidden, 3)), start=1
    ):
        tensors[f"layer{number}"] = _linear(generator, width, outputs)
        bound = 1 / math.sqrt(width) if number < 3 else 0.0
        tensors[f"bias{number}"] = _uniform(generator, bound, (1, outputs))
    return tensors


def decoded(tensors: Mapping[str, Tensor], products: Tensor, directions: Tensor, settings: TensorfSettings) -> Tensor:
    """Return the colours of samples, ``[m, 3]`` in 0..1, of harmonics at least 0.

    Args:
        tensors: of the decoder.
        products: ``[m, 3 * components]``.
        directions: ``[m, 3]``, of length 1, away from the camera.
        settings: of the representation.
    """
    features = products @ tensors["basis"]
    if settings.decoder == "sh":
        harmonics = features.view(-1, 3, 9) * _harmonics(directions)[:, None]
        return torch.relu(harmonics.sum(dim=2) + 0.5)
    values = torch.cat([features, directions], dim=1)
    read = torch.cat([values, *_waves(values, settings.frequencies)], dim=1)
    for number in (1, 2):
        read = torch.relu(read @ tensors[f"layer{number}"] + tensors[f"bias{number}"])
    return torch.sigmoid(read @ tensors["layer3"] + tensors["bias3"])


def _waves(values: Tensor, frequencies: int) -> list[Tensor]:
    """Return sine and cosine of the values at frequencies 1, 2, 4 and so on."""
    phases = [values * 2**power for power in range(frequencies)]
    return [wave(phase) for phase in phases for wave in (torch.sin, torch.cos)]


def _harmonics(directions: Tensor) -> Tensor:
    """Return the nine real spherical harmonics up to degree 2 at unit vectors, ``[m, 9]``."""
    x, y, z = directions.unbind(dim=1)
    flat = math.sqrt(1 / (4 * math.pi))
    first, second = math.sqrt(3 / (4 * math.pi)), math.sqrt(15 / (4 * math.pi))
    third = math.sqrt(5 / (16 * math.pi))
    return torch.stack(
        [
            torch.full_like(x, flat),
            -first * y,
            first * z,
            -first * x,
            second * x * y,
            -second * y * z,
            third * (2 * z * z - x * x - y * y),
            -second * x * z,
            second / 2 * (x * x - y * y),
        ],
        dim=1,
    )


def _linear(generator: np.random.Generator, inputs: int, outputs: int) -> Tensor:
    return _uniform(generator, 1 / math.sqrt(inputs), (inputs, outputs))


def _uniform(generator: np.random.Generator, bound: float, shape: tuple[int, int]) -> Tensor:
    return torch.from_numpy(generator.uniform(-bound, bound, shape).astype(np.float32))
