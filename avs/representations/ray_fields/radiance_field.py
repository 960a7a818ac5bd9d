"""A radiance field as a representation: drawn pixels, optimiser, renderings and checkpoints, whatever the field is."""

from __future__ import annotations

import copy
import json
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

import numpy as np
import torch
from torch import Tensor
from torch.nn import Parameter

from avs.representations.base import Rendering, RepresentationSettings
from avs.representations.ray_fields.camera_rays import Rays, image_rays
from avs.representations.ray_fields.field_adam import FieldAdam
from avs.representations.ray_fields.field_checkpoint import FieldState, read_field, write_field
from avs.representations.ray_fields.photograph_pixels import Batch, PixelPool, drawn_pixels, pixel_pool
from avs.representations.torch_devices import torch_device
from avs.scene.cameras import Cameras
from avs.scene.similarity import Similarity
from avs.scene.views import Views
from avs.system.errors import UserError

CHECK_EVERY = 100
"""Steps between checks that every parameter is finite."""

RAYS_TOGETHER = 2048
"""Rays of one part of a rendering: what is computed of them stays in a processor's cache."""


class Field(Protocol):
    """What differs between kinds of fields.

    Attributes:
        parameters: the trainable tensors by name; ``before_step`` may replace some.
    """

    parameters: dict[str, Parameter]

    def rates(self, step: int) -> Mapping[str, float]:
        """Return the learning rate of each parameter at a step, counted from 1."""
        ...

    def before_step(self, step: int, *, new_views: bool) -> set[str]:
        """Follow the schedules of a step, and return the names of the parameters that were replaced.

        Args:
            step: counted from 1.
            new_views: whether photographs have come since the last step.
        """
        ...

    def loss(self, batch: Batch, step: int, generator: np.random.Generator) -> Tensor:
        """Return what a step minimises, a scalar; ``generator`` is the source of every random choice."""
        ...

    def rendered(self, rays: Rays) -> tuple[Tensor, Tensor, Tensor]:
        """Return colour ``[n, 3]``, sum of weights times distance ``[n]``, and opacity ``[n]`` of rays."""
        ...

    def kept(self) -> dict[str, Tensor]:
        """Return what further steps depend on beside the parameters."""
        ...

    def restore(self, parameters: Mapping[str, Tensor], kept: Mapping[str, Tensor]) -> None:
        """Take the tensors that were saved, whatever their sizes are now."""
        ...


class RadianceField:
    """A radiance field; a ``Representation`` that can be copied.

    Attributes:
        settings: of the reconstruction.
        iteration: optimisation steps done so far.
        field: what is optimised.
    """

    def __init__(
        self,
        field: Field,
        settings: RepresentationSettings,
        optimizer: FieldAdam,
        rays_per_step: int,
        place: tuple[float, Similarity],
        export: str,
        generator: np.random.Generator,
        device: str,
    ) -> None:
        """Start untrained.

        Args:
            field: the untrained field.
            settings: of the reconstruction.
            optimizer: without moments.
            rays_per_step: pixels of one step.
            place: radius of the field's inner box in scene units, and the map to the coordinates of the capture.
            export: name of the file that ``export`` writes.
            generator: source of every random choice from here on.
            device: ``cpu`` or ``cuda``.
        """
        self.field = field
        self.settings = settings
        self.iteration = 0
        self._optimizer = optimizer
        self._rays_per_step = rays_per_step
        self._radius, self._to_capture = place
        self._export = export
        self._generator = generator
        self._device = torch_device(device)
        self._pool: PixelPool | None = None
        self._photographs: list[str] = []

    @property
    def primitives(self) -> int:
        """None: a field is no sum of things that could be counted."""
        return 0

    def fit(self, views: Views, iterations: int) -> None:
        """Optimise on ``views`` for ``iterations`` more steps, each on pixels drawn from all of them.

        Raises:
            UserError: parameters stopped being finite.
        """
        if self._pool is None or self._pool.names != views.names:
            self._pool = pixel_pool(views)
        for _ in range(iterations):
            step, names = self.iteration + 1, list(views.names)
            replaced = self.field.before_step(step, new_views=names != self._photographs)
            self._photographs = names
            self._optimizer.forget(replaced)
            batch = drawn_pixels(self._pool, self._generator, self._rays_per_step, self._device)
            self.field.loss(batch, step, self._generator).backward()  # type: ignore[no-untyped-call]
            self._optimizer.step(self.field.parameters, self.field.rates(step))
            self.iteration = step
            if step % CHECK_EVERY == 0:
                self._check_finite()
        self._check_finite()

    def render(self, cameras: Cameras) -> Rendering:
        """Render ``cameras``, which share one image size; depth is the expected depth, colours are clamped to 0..1.

        Raises:
            ValueError: the image sizes differ, or there is no camera.
        """
        sizes = list(cameras.by_size())
        if len(sizes) != 1:
            raise ValueError(f"expected cameras of one image size, got {len(sizes)} sizes")
        ((width, height), _), images = sizes[0], []
        with torch.no_grad():
            for index in range(len(cameras)):
                rays = image_rays(cameras[index], self._device)
                parts = [rays.part(begin, begin + RAYS_TOGETHER) for begin in range(0, len(rays), RAYS_TOGETHER)]
                rgb, distance, alpha = map(torch.cat, zip(*map(self.field.rendered, parts), strict=True))
                depth = torch.where(
                    alpha > 0, distance / alpha.clamp_min(1e-12) * rays.along_axis, torch.zeros_like(alpha)
                )
                images.append((rgb.clamp(0, 1).cpu(), depth.cpu(), alpha.clamp(0, 1).cpu()))
        colors, depths, alphas = (torch.stack(each).numpy() for each in zip(*images, strict=True))
        shape = (len(cameras), height, width)
        return Rendering(colors.reshape(*shape, 3), depths.reshape(shape), alphas.reshape(shape))

    def copy(self, seed: int | None = None) -> RadianceField:
        """Return an independent copy that goes on with the same bits, or with a generator of its own of this seed."""
        shared = {} if self._pool is None else {id(self._pool): self._pool}
        twin = copy.deepcopy(self, shared)
        if seed is not None:
            twin._generator = np.random.Generator(np.random.PCG64(seed))
        return twin

    def fingerprint(self) -> int:
        """Return a checksum of the parameters and of the generator's state."""
        state = json.dumps(self._generator.bit_generator.state, sort_keys=True, default=str)
        found = zlib.crc32(state.encode())
        for values in self.field.parameters.values():
            found = zlib.crc32(values.detach().cpu().contiguous().numpy().data, found)
        return found

    def export(self, folder: Path) -> None:
        """Write the field without the optimiser's moments to ``folder``: tensors by name, and a header as JSON."""
        write_field(folder / self._export, self._tensors(), self._state())

    def save(self, path: Path) -> None:
        """Write parameters, optimiser moments, counters and the generator's state to ``path``."""
        moments = {
            f"{name}.{order}": each
            for name, pair in self._optimizer.moments.items()
            for order, each in zip(("first", "second"), pair, strict=True)
        }
        write_field(path, self._tensors() | moments, self._state())

    def load(self, path: Path) -> None:
        """Restore what ``save`` wrote; further steps give the same bits as without interruption.

        Raises:
            UserError: the file cannot be read, is of other settings or another scene, or is an export.
        """
        tensors, state = read_field(path)
        own = (self.settings.model_dump(mode="json"), self._radius, self._to_capture)
        if (state.settings, state.radius, state.to_capture) != own:
            raise UserError(path, "was written with other settings or for another scene", "fit again")
        if any(f"{name}.first" not in tensors for name in state.adam_steps):
            raise UserError(path, "has no moments of the optimiser: it is an export", "give a checkpoint, or fit again")
        tensors = {name: tensor.to(self._device) for name, tensor in tensors.items()}
        kept = {name.removeprefix("kept."): each for name, each in tensors.items() if name.startswith("kept.")}
        self.field.restore({name: tensors[name] for name in self.field.parameters}, kept)
        self._optimizer.steps = dict(state.adam_steps)
        self._optimizer.moments = {
            name: (tensors[f"{name}.first"], tensors[f"{name}.second"]) for name in state.adam_steps
        }
        self.iteration, self._photographs, self._pool = state.iteration, list(state.photographs), None
        self._generator.bit_generator.state = state.generator

    def _tensors(self) -> dict[str, Tensor]:
        kept = {f"kept.{name}": each for name, each in self.field.kept().items()}
        return {**self.field.parameters, **kept}

    def _state(self) -> FieldState:
        return FieldState(
            settings=self.settings.model_dump(mode="json"),
            radius=self._radius,
            to_capture=self._to_capture,
            iteration=self.iteration,
            adam_steps=dict(self._optimizer.steps),
            photographs=self._photographs,
            generator=dict(self._generator.bit_generator.state),
        )

    def _check_finite(self) -> None:
        broken = [name for name, each in self.field.parameters.items() if not bool(torch.isfinite(each).all())]
        if broken:
            remedy = "lower the learning rates or check the scene's cameras"
            subject = f"reconstruction at step {self.iteration}"
            raise UserError(subject, f"{', '.join(broken)} stopped being finite", remedy)
