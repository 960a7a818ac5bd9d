"""What the optimisation of Gaussians stands at: tensors for a checkpoint and back, and a checksum."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from typing import Any

from torch import Tensor

from avs.representations.gaussians.optimization import Optimizers
from avs.representations.gaussians.parameters import Parameters

_MOMENTS = ("exp_avg", "exp_avg_sq")


def optimizer_tensors(parameters: Parameters, optimizers: Optimizers) -> tuple[dict[str, Tensor], dict[str, int]]:
    """Return the parameters and the moments of each one's Adam by name, and the steps that each has done."""
    tensors: dict[str, Tensor] = dict(parameters)
    adam_steps = {}
    for name, optimizer in optimizers.items():
        moments = dict(optimizer.state[parameters[name]])
        adam_steps[name] = moments.pop("step", 0)
        tensors |= {f"{name}.{key}": value for key, value in moments.items()}
    return tensors, adam_steps


def restore_moments(
    parameters: Parameters, optimizers: Optimizers, tensors: Mapping[str, Tensor], adam_steps: Mapping[str, int]
) -> None:
    """Give new optimisers of ``parameters`` the moments that ``optimizer_tensors`` returned."""
    for name, optimizer in optimizers.items():
        if adam_steps[name]:
            moments = {key: tensors[f"{name}.{key}"] for key in _MOMENTS}
            optimizer.state[parameters[name]] = {"step": adam_steps[name], **moments}


def checksum(parameters: Parameters, generator: Mapping[str, Any]) -> int:
    """Return a checksum of all parameters, in order, and of a generator's state."""
    found = zlib.crc32(json.dumps(generator, sort_keys=True, default=str).encode())
    for values in parameters.values():
        found = zlib.crc32(values.detach().cpu().contiguous().numpy().data, found)
    return found
