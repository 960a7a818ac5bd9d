"""The small networks of Nerfacto: densities of grids, and colours of features, directions and photographs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

import numpy as np
import torch
from torch import Tensor

from avs.representations.nerfacto.hash_grid import FEATURES, cells_of, initial_tables, looked_up
from avs.representations.nerfacto.nerfacto_settings import HashGrid, NerfactoSettings

GEOMETRY = 15
"""Features that the density's network hands to that of the colour."""

HARMONICS = 16
"""Of degree 3 and below, of which the directions are read."""

LARGEST = 15.0
"""Exponents above this have the gradient of this, as in nerfstudio."""


def initial_tensors(settings: NerfactoSettings, photographs: int, generator: np.random.Generator) -> dict[str, Tensor]:
    """Return the untrained tensors by name; layers are ``[inputs, outputs]``, drawn as torch's linear layers are."""
    tensors = {}
    for number, proposal in enumerate(settings.proposals):
        width = proposal.grid.levels * FEATURES
        tensors[f"proposal{number}.tables"] = initial_tables(proposal.grid, generator)
        tensors |= _layers(f"proposal{number}", (width, settings.proposal_hidden, 1), generator)
    width = settings.grid.levels * FEATURES
    tensors["density.tables"] = initial_tables(settings.grid, generator)
    tensors |= _layers("density", (width, settings.hidden, 1 + GEOMETRY), generator)
    inputs = HARMONICS + GEOMETRY + settings.appearance
    tensors |= _layers("color", (inputs, settings.hidden, settings.hidden, 3), generator)
    if settings.appearance:
        embedded = generator.standard_normal((photographs, settings.appearance))
        tensors["appearance"] = torch.from_numpy(embedded.astype(np.float32))
    return tensors


def density_and_features(
    tensors: Mapping[str, Tensor], name: str, grid: HashGrid, factor: float, places: Tensor
) -> tuple[Tensor, Tensor]:
    """Return the density ``[n]`` and further outputs ``[n, m]`` of a grid's network at places ``[n, 3]`` in -2..2."""
    found = looked_up(tensors[f"{name}.tables"], cells_of(grid), places)
    out = _network(tensors, name, found)
    return factor * _bounded_exp(out[:, 0]), out[:, 1:]


def colors(tensors: Mapping[str, Tensor], features: Tensor, directions: Tensor, appearance: Tensor | None) -> Tensor:
    """Return colours ``[rays * samples, 3]`` in 0..1.

    Args:
        tensors: of the field.
        features: ``[rays * samples, 15]`` of the density's network, ray by ray.
        directions: ``[rays, 3]``, of length 1.
        appearance: ``[rays, m]`` of the photographs, or None for none.
    """
    of_rays = [_harmonics(directions), *([] if appearance is None else [appearance])]
    samples = len(features) // len(directions)
    read = [torch.cat(of_rays, dim=1).repeat_interleave(samples, dim=0), features]
    return torch.sigmoid(_network(tensors, "color", torch.cat(read, dim=1)))


def _network(tensors: Mapping[str, Tensor], name: str, values: Tensor) -> Tensor:
    number = 0
    while f"{name}.layer{number}" in tensors:
        values = torch.relu(values) if number else values
        values = values @ tensors[f"{name}.layer{number}"] + tensors[f"{name}.bias{number}"]
        number += 1
    return values


def _bounded_exp(values: Tensor) -> Tensor:
    return torch.exp(values.clamp(max=LARGEST)) + (values - values.clamp(max=LARGEST)) * math.exp(LARGEST)


def _layers(name: str, widths: tuple[int, ...], generator: np.random.Generator) -> dict[str, Tensor]:
    tensors = {}
    for number, (inputs, outputs) in enumerate(itertools.pairwise(widths)):
        bound = 1 / math.sqrt(inputs)
        for part, shape in (("layer", (inputs, outputs)), ("bias", (1, outputs))):
            values = generator.uniform(-bound, bound, shape).astype(np.float32)
            tensors[f"{name}.{part}{number}"] = torch.from_numpy(values)
    return tensors


def _harmonics(directions: Tensor) -> Tensor:
    """Return the sixteen real spherical harmonics up to degree 3 at unit vectors, ``[n, 16]``."""
    x, y, z = directions.unbind(dim=1)
    xx, yy, zz = x * x, y * y, z * z
    return torch.stack(
        [
            torch.full_like(x, 0.28209479),
            -0.48860251 * y,
            0.48860251 * z,
            -0.48860251 * x,
            1.09254843 * x * y,
            -1.09254843 * y * z,
            0.31539157 * (2 * zz - xx - yy),
            -1.09254843 * x * z,
            0.54627421 * (xx - yy),
            -0.59004359 * y * (3 * xx - yy),
            2.89061144 * x * y * z,
            -0.45704580 * y * (4 * zz - xx - yy),
            0.37317633 * z * (2 * zz - 3 * xx - 3 * yy),
            -0.45704580 * x * (4 * zz - xx - yy),
            1.44530572 * z * (xx - yy),
            -0.59004359 * x * (xx - 3 * yy),
        ],
        dim=1,
    )
