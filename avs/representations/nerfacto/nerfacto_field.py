"""The field of Nerfacto: proposals, density and colour, losses and renderings (arXiv 2302.04264)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor
from torch.nn import Parameter

from avs.representations.nerfacto.nerfacto_networks import colors, density_and_features, initial_tensors
from avs.representations.nerfacto.nerfacto_settings import HashGrid, NerfactoSettings
from avs.representations.nerfacto.proposal_sampling import (
    distortion_loss,
    drawn_edges,
    even_edges,
    interlevel_loss,
    weights_of,
)
from avs.representations.ray_fields.camera_rays import Rays
from avs.representations.ray_fields.field_adam import FieldAdam
from avs.representations.ray_fields.photograph_pixels import Batch
from avs.representations.ray_fields.radiance_field import RadianceField
from avs.representations.ray_fields.unbounded_space import BALL, contracted, distance_at, spacing_of
from avs.representations.torch_devices import torch_device
from avs.scene.cameras import IndexArray
from avs.scene.scene import Scene
from avs.scene.similarity import Similarity

BETAS, EPSILON = (0.9, 0.999), 1e-15
"""Of Adam, in nerfstudio."""

TURN = 1.0
"""Samples lie evenly as far as the inner box's half side, and beyond evenly in 1 / distance."""

SLOPE = 10.0
"""Of the annealing of proposals (arXiv 2111.12077, equation 18)."""


def build(scene: Scene, captured: IndexArray, settings: NerfactoSettings, seed: int, device: str) -> RadianceField:
    """Return an untrained field for ``scene``.

    Args:
        scene: its extent and number of images are used; points and images are not.
        captured: does not matter.
        settings: of the reconstruction.
        seed: of every random choice of the reconstruction.
        device: ``cpu`` or ``cuda``.

    Raises:
        UserError: the device is not there.
    """
    return field_in(settings, scene.extent / BALL, scene.to_capture, seed, device, len(scene.names))


def field_in(
    settings: NerfactoSettings, radius: float, to_capture: Similarity, seed: int, device: str, photographs: int = 1
) -> RadianceField:
    """Return an untrained field around the origin, ``radius`` being the half side of its inner box in scene units."""
    generator = np.random.Generator(np.random.PCG64(seed))
    field = NerfactoField(settings, radius, photographs, generator, torch_device(device))
    optimizer, place = FieldAdam(BETAS, EPSILON), (radius, to_capture)
    return RadianceField(field, settings, optimizer, settings.rays, place, "nerfacto.safetensors", generator, device)


@dataclass(frozen=True)
class _Intervals:
    """Intervals of rays, of the field or of a proposal: edges ``[rays, n + 1]`` and weights ``[rays, n]``."""

    edges: Tensor
    weights: Tensor


class NerfactoField:
    """See ``avs.representations.ray_fields.radiance_field.Field``.

    Attributes:
        parameters: see ``nerfacto_networks.initial_tensors``.
    """

    def __init__(
        self,
        settings: NerfactoSettings,
        radius: float,
        photographs: int,
        generator: np.random.Generator,
        device: torch.device,
    ) -> None:
        """Start untrained; as many photographs have an appearance of their own, in order of capture."""
        self._settings = settings
        self._radius = radius
        self._device = device
        self._seen = torch.zeros(max(1, photographs), dtype=torch.bool, device=device)
        tensors = initial_tensors(settings, len(self._seen), generator)
        self.parameters = {name: Parameter(tensor.to(device)) for name, tensor in tensors.items()}
        bounds = torch.tensor([settings.near * BALL, settings.far * BALL])
        self._begin, self._end = spacing_of(bounds, TURN).tolist()

    def rates(self, step: int) -> Mapping[str, float]:
        """Return the rate of all, exponential in the step."""
        told = self._settings
        return dict.fromkeys(
            self.parameters, told.learning_rate * math.pow(told.final_rate, min(step / told.iterations, 1.0))
        )

    def before_step(self, step: int, *, new_views: bool) -> set[str]:
        """Do nothing: no tensor is replaced."""
        return set()

    def loss(self, batch: Batch, step: int, generator: np.random.Generator) -> Tensor:
        """Return the mean squared error of colours, with the losses of proposals and of distortion."""
        told = self._settings
        shape = (len(told.proposals) + 1, len(batch.rays))
        offsets = torch.from_numpy(generator.random(shape, dtype=np.float32)).to(self._device)
        self._seen[batch.photographs] = True
        progress = min(step / told.annealing, 1.0) if told.annealing else 1.0
        rgb, _, _, (*proposals, field) = self._composed(batch.rays, offsets, batch.photographs, annealed(progress))
        loss = torch.mean((rgb - batch.colors) ** 2)
        for each in proposals:
            loss = loss + told.interlevel * interlevel_loss(field.edges, field.weights, each.edges, each.weights)
        return loss + told.distortion * distortion_loss(field.edges, field.weights)

    def rendered(self, rays: Rays) -> tuple[Tensor, Tensor, Tensor]:
        """Return colour, weighted distance and opacity of rays, with the mean appearance of all photographs so far."""
        offsets = torch.full((len(self._settings.proposals) + 1, len(rays)), 0.5, device=self._device)
        rgb, distance, alpha, _ = self._composed(rays, offsets, None, 1.0)
        return rgb, distance, alpha

    def kept(self) -> dict[str, Tensor]:
        """Return which photographs were seen."""
        return {"seen": self._seen}

    def restore(self, parameters: Mapping[str, Tensor], kept: Mapping[str, Tensor]) -> None:
        """Take what was saved."""
        self.parameters = {name: Parameter(tensor) for name, tensor in parameters.items()}
        self._seen = kept["seen"].clone()

    def _composed(
        self, rays: Rays, offsets: Tensor, photographs: Tensor | None, power: float
    ) -> tuple[Tensor, Tensor, Tensor, list[_Intervals]]:
        """Return colour, weighted distance, opacity, and the intervals of proposals and field."""
        told, found = self._settings, list[_Intervals]()
        edges = even_edges(len(rays), told.proposals[0].samples, self._begin, self._end, offsets[0])
        for number, proposal in enumerate(told.proposals):
            weights, _, _ = self._weights(f"proposal{number}", proposal.grid, rays, edges)
            found.append(_Intervals(edges, weights))
            following = [*(each.samples for each in told.proposals[1:]), told.samples][number]
            edges = drawn_edges(edges, weights.detach() ** power, following, offsets[number + 1])
        weights, features, middles = self._weights("density", told.grid, rays, edges)
        found.append(_Intervals(edges, weights))
        shown = self._colors(features, rays, photographs)
        rgb, alpha = (weights[..., None] * shown).sum(dim=1), weights.sum(dim=1)
        background = torch.tensor(told.background, device=self._device)
        distance = (weights.detach() * middles).sum(dim=1) * self._radius
        return rgb + (1 - alpha)[:, None] * background, distance, alpha, found

    def _weights(self, name: str, grid: HashGrid, rays: Rays, edges: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return weights ``[rays, n]``, the network's other outputs, and the distances of the intervals' middles."""
        distances = distance_at(edges, TURN)
        middles = (distances[:, 1:] + distances[:, :-1]) / 2
        points = rays.origins[:, None] / self._radius + middles[..., None] * rays.directions[:, None]
        places = contracted(points).reshape(-1, 3)
        density, others = density_and_features(self.parameters, name, grid, self._settings.initial_density, places)
        return weights_of(density.view_as(middles), distances.diff(dim=1)), others, middles

    def _colors(self, features: Tensor, rays: Rays, photographs: Tensor | None) -> Tensor:
        """Return the colours of the field's intervals, ``[rays, n, 3]``."""
        appearance = None
        if self._settings.appearance:
            table = self.parameters["appearance"]
            appearance = table[photographs] if photographs is not None else self._mean_appearance(table, len(rays))
        return colors(self.parameters, features, rays.directions, appearance).view(len(rays), -1, 3)

    def _mean_appearance(self, table: Tensor, rays: int) -> Tensor:
        own = table[self._seen] if bool(self._seen.any()) else table
        return own.mean(dim=0, keepdim=True).expand(rays, -1)


def annealed(progress: float) -> float:
    """Return the power to which weights of proposals are raised, from 0 to 1 with the progress."""
    return SLOPE * progress / ((SLOPE - 1) * progress + 1)
