"""The field of TensoRF: planes and lines from coarse to fine, empty space, loss and renderings (arXiv 2203.09517)."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import torch
from torch import Tensor
from torch.nn import Parameter
from torch.nn.functional import interpolate, max_pool3d, softplus

from avs.representations.ray_fields.camera_rays import Rays
from avs.representations.ray_fields.field_adam import FieldAdam
from avs.representations.ray_fields.photograph_pixels import Batch
from avs.representations.ray_fields.radiance_field import RadianceField
from avs.representations.ray_fields.unbounded_space import BALL
from avs.representations.tensorf import vector_matrix_kernels
from avs.representations.tensorf.appearance_decoder import decoded, decoder_tensors
from avs.representations.tensorf.tensorf_settings import TensorfSettings
from avs.representations.tensorf.vector_matrix_lookup import March, marched, products
from avs.representations.torch_devices import torch_device
from avs.scene.cameras import IndexArray
from avs.scene.scene import Scene
from avs.scene.similarity import Similarity

BETAS, EPSILON = (0.9, 0.99), 1e-8
"""Of Adam, in the public code."""

INITIAL_SIZE = 0.1
"""Standard deviation of planes and lines at the start, in the public code."""

TURN = 2.0
"""Samples lie evenly as far as across the inner box, in units of its half side, and beyond evenly in 1 / distance."""

LONGEST = 64
"""Planes of more cells than this are looked up in parts of so many layers, when it is found where nothing is."""


def build(scene: Scene, captured: IndexArray, settings: TensorfSettings, seed: int, device: str) -> RadianceField:
    """Return an untrained field for ``scene``.

    Args:
        scene: its extent is used; points and images are not.
        captured: does not matter.
        settings: of the reconstruction.
        seed: of every random choice of the reconstruction.
        device: ``cpu`` or ``cuda``.

    Raises:
        UserError: the device is not there.
    """
    return field_in(settings, scene.extent / BALL, scene.to_capture, seed, device)


def field_in(settings: TensorfSettings, radius: float, to_capture: Similarity, seed: int, device: str) -> RadianceField:
    """Return an untrained field around the origin, ``radius`` being the half side of its inner box in scene units."""
    generator = np.random.Generator(np.random.PCG64(seed))
    field = VectorMatrixField(settings, radius, generator, torch_device(device))
    optimizer = FieldAdam(BETAS, EPSILON)
    place = (radius, to_capture)
    return RadianceField(field, settings, optimizer, settings.rays, place, "tensorf.safetensors", generator, device)


class VectorMatrixField:
    """See ``avs.representations.ray_fields.radiance_field.Field``.

    Attributes:
        parameters: ``density_planes`` ``[3, cells, cells, components]``, ``density_lines`` ``[3, cells, components]``,
            the same of the appearance, and the decoder's.
        filled: ``[cells, cells, cells]`` uint8, 0 where an optimisation takes no samples.
    """

    def __init__(
        self, settings: TensorfSettings, radius: float, generator: np.random.Generator, device: torch.device
    ) -> None:
        """Start untrained; ``radius`` is the half side of the inner box in scene units."""
        self._settings = settings
        self._radius = radius
        self._device = device
        self._full = torch.ones((1, 1, 1), dtype=torch.uint8, device=device)
        self.filled = self._full
        self._seen_filled: Tensor | None = None
        self._looked = 0
        tensors, cells = {}, settings.grid.initial
        for name, components in (
            ("density", settings.density_components),
            ("appearance", settings.appearance_components),
        ):
            for part, shape in (("planes", (3, cells, cells, components)), ("lines", (3, cells, components))):
                values = generator.standard_normal(shape, dtype=np.float32) * np.float32(INITIAL_SIZE)
                tensors[f"{name}_{part}"] = torch.from_numpy(values)
        tensors |= decoder_tensors(settings, generator)
        self.parameters = {name: Parameter(tensor.to(device)) for name, tensor in tensors.items()}

    def rates(self, step: int) -> Mapping[str, float]:
        """Return the rates: exponential in the step, down to ``final_rate`` of those at the start."""
        part = self._settings.final_rate ** min(step / self._settings.iterations, 1.0)
        rates = {True: self._settings.grid_rate * part, False: self._settings.network_rate * part}
        return {name: rates[name in GRIDS] for name in self.parameters}

    def before_step(self, step: int, *, new_views: bool) -> set[str]:
        """Refine the grids and look for empty space where the step's turn is; see ``Field``.

        Where new views have come, nothing counts as empty until the next look: what nobody has seen looks empty.
        """
        self._seen_filled = None
        if new_views:
            self.filled, self._looked = self._full, step
        elif step - self._looked >= self._settings.empty_space.every:
            self.filled, self._looked = self._find_filled(), step
        grid = self._settings.grid
        if step not in grid.refine_at:
            return set()
        cells = cells_after(grid.refine_at.index(step) + 1, grid.initial, grid.final, len(grid.refine_at))
        for name in GRIDS:
            self.parameters[name] = Parameter(refined(self.parameters[name].detach(), cells))
        return set(GRIDS)

    def loss(self, batch: Batch, step: int, generator: np.random.Generator) -> Tensor:
        """Return the mean squared error of colours, with the penalties of the settings."""
        offsets = generator.random(len(batch.rays), dtype=np.float32)
        rgb, _, _ = self._composed(batch.rays, torch.from_numpy(offsets).to(self._device), self.filled)
        loss = torch.mean((rgb - batch.colors) ** 2)
        told, tensors = self._settings, self.parameters
        if told.sparsity:
            parts = (tensors["density_planes"], tensors["density_lines"])
            loss = loss + told.sparsity * sum(part.abs().mean() * 3 for part in parts)
        for weight, name in (
            (told.smoothness_density, "density_planes"),
            (told.smoothness_appearance, "appearance_planes"),
        ):
            if weight:
                loss = loss + weight * total_variation(tensors[name])
        return loss

    def rendered(self, rays: Rays) -> tuple[Tensor, Tensor, Tensor]:
        """Return colour, weighted distance and opacity of rays, sampled at the middle of each interval."""
        if self._seen_filled is None:
            self._seen_filled = self._find_filled()
        offsets = torch.full((len(rays),), 0.5, device=self._device)
        return self._composed(rays, offsets, self._seen_filled)

    def kept(self) -> dict[str, Tensor]:
        """Return where samples are taken, and the step of the last look."""
        return {"filled": self.filled, "looked": torch.tensor([self._looked])}

    def restore(self, parameters: Mapping[str, Tensor], kept: Mapping[str, Tensor]) -> None:
        """Take what was saved."""
        self.parameters = {name: Parameter(tensor) for name, tensor in parameters.items()}
        self.filled, self._looked, self._seen_filled = kept["filled"], int(kept["looked"][0]), None

    def _composed(self, rays: Rays, offsets: Tensor, filled: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        told, tensors = self._settings, self.parameters
        near = told.near * BALL
        march = March(filled, near, TURN, told.density_shift, told.density_scale, told.least_weight, told.samples)
        origins = rays.origins / self._radius
        planes, lines = tensors["density_planes"], tensors["density_lines"]
        places, owners, distances, weights = marched(planes, lines, origins, rays.directions, offsets, march)
        shown = torch.nonzero(weights.detach() > told.least_weight)[:, 0]
        found = products(tensors["appearance_planes"], tensors["appearance_lines"], places[shown])
        colors = decoded(tensors, found, rays.directions[owners[shown]], told)
        zeros = torch.zeros((len(rays), 3), device=self._device)
        rgb = zeros.index_add(0, owners[shown], weights[shown, None] * colors)
        alpha = zeros[:, 0].index_add(0, owners, weights)
        distance = zeros[:, 0].index_add(0, owners, weights.detach() * distances * self._radius)
        background = torch.tensor(told.background, device=self._device)
        return rgb + (1 - alpha)[:, None] * background, distance, alpha

    @torch.no_grad()
    def _find_filled(self) -> Tensor:
        """Return where something may be: a cell or one beside it has an opacity over its side."""
        told = self._settings
        size = told.empty_space.cells
        middles = (torch.arange(size, device=self._device) + 0.5) * (4 / size) - 2
        layers = []
        for begin in range(0, size, LONGEST):
            axes = torch.meshgrid(middles[begin : begin + LONGEST], middles, middles, indexing="ij")
            places = torch.stack(axes, dim=-1).reshape(-1, 3).contiguous()
            layers.append(self._features(places))
        features = torch.cat(layers).reshape(1, 1, size, size, size)
        opacity = 1 - torch.exp(-softplus(features + told.density_shift) * told.density_scale * (4 / size))
        return (max_pool3d(opacity, 3, stride=1, padding=1)[0, 0] >= told.empty_space.opacity).to(torch.uint8)

    def _features(self, places: Tensor) -> Tensor:
        planes, lines = self.parameters["density_planes"].detach(), self.parameters["density_lines"].detach()
        if self._device.type != "cpu":
            return products(planes, lines, places).sum(dim=1)
        return torch.from_numpy(vector_matrix_kernels.features_at(*(each.numpy() for each in (planes, lines, places))))


GRIDS = ("density_planes", "density_lines", "appearance_planes", "appearance_lines")
"""The parameters that are refined."""


def cells_after(refinements: int, initial: int, final: int, of: int) -> int:
    """Return the cells a side after some refinements of ``of``: their number grows by equal factors."""
    return round(initial * math.pow(final / initial, refinements / of))


def refined(tensor: Tensor, cells: int) -> Tensor:
    """Return planes ``[3, n, n, components]`` or lines ``[3, n, components]`` with ``cells`` a side, linearly."""
    first = tensor.movedim(-1, 1)
    if tensor.dim() == 3:
        return interpolate(first, size=cells, mode="linear", align_corners=True).movedim(1, -1).contiguous()
    found = interpolate(first, size=(cells, cells), mode="bilinear", align_corners=True)
    return found.movedim(1, -1).contiguous()


def total_variation(planes: Tensor) -> Tensor:
    """Return the mean squared difference of neighbouring cells, of both directions together."""
    return planes.diff(dim=1).square().mean() + planes.diff(dim=2).square().mean()
