"""3D Gaussian splatting as a representation: fit, render, Fisher information, checkpoints (arXiv 2308.04079)."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch

from avs.rasterizer.losses import Target, prepare_target
from avs.representations.base import FloatImages, Rendering
from avs.representations.capabilities import FisherInformation
from avs.representations.gaussians.blending_weights import WeightSums, blended_values, front_weights
from avs.representations.gaussians.densification import STATISTICS, DensityControl
from avs.representations.gaussians.gaussian_checkpoint import CheckpointState, read_checkpoint, write_checkpoint
from avs.representations.gaussians.gaussian_settings import GaussianSettings
from avs.representations.gaussians.initialization import PointCloud, initial_points, reference_ball
from avs.representations.gaussians.objective import LOG_VARIANCES, LikelihoodObjective, Objective, PhotometricObjective
from avs.representations.gaussians.optimization import active_degree, create_optimizers, follow_schedules
from avs.representations.gaussians.parameter_information import parameter_fisher
from avs.representations.gaussians.parameters import (
    NAMES,
    Parameters,
    check_finite,
    create_parameters,
    extend_parameters,
)
from avs.representations.gaussians.ply import write_ply
from avs.representations.gaussians.probes import probe_views
from avs.representations.gaussians.rendering import rasterizer_arguments, rendered
from avs.representations.gaussians.training_state import checksum, optimizer_tensors, restore_moments
from avs.representations.gaussians.variance import variance_reductions
from avs.representations.learned_variance import VarianceLearning, VarianceReduction
from avs.representations.torch_devices import torch_device
from avs.scene.cameras import Cameras, IndexArray
from avs.scene.scene import Scene
from avs.scene.similarity import IDENTITY, Similarity
from avs.scene.views import Views
from avs.system.errors import UserError

CHECK_EVERY = 100
"""Steps between checks that every parameter is finite."""


def build(scene: Scene, captured: IndexArray, settings: GaussianSettings, seed: int, device: str) -> GaussianSplats:
    """Return untrained Gaussians for ``scene``.

    Args:
        scene: its cameras, points and extent are used, its images are not.
        captured: indices of the images captured so far, which matter to the initial points ``selected`` alone.
        settings: of the reconstruction.
        seed: of every random choice of the reconstruction.
        device: ``cpu`` or ``cuda``.

    Raises:
        UserError: the device is not there, or the scene has too few points for the initial points asked for.
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    ball = reference_ball(scene, settings.extent)
    cloud = initial_points(scene, ball, captured, settings.points, generator)
    return GaussianSplats(cloud, ball[1], settings, generator, device, scene.to_capture)


class GaussianSplats:
    """Trainable 3D Gaussians; a ``Representation`` with every capability of ``avs.representations.capabilities``.

    Attributes:
        settings: of the reconstruction.
        extent: of the scene, which positions' rates and thresholds are relative to.
        to_capture: from the scene's coordinates to those of the capture, which exports have.
        parameters: the trainable tensors, see ``parameters.py``, and the log-variances, where they are learned.
        iteration: optimisation steps done so far.
    """

    def __init__(
        self,
        cloud: PointCloud,
        extent: float,
        settings: GaussianSettings,
        generator: np.random.Generator,
        device: str,
        to_capture: Similarity = IDENTITY,
    ) -> None:
        """Start at the points of ``cloud``; ``generator`` is the source of every random choice from here on.

        Raises:
            UserError: the device is not there.
        """
        self.settings = settings
        self.extent = extent
        self.to_capture = to_capture
        self.iteration = 0
        self._device = torch_device(device)
        self._generator = generator
        self.parameters: Parameters = create_parameters(
            cloud, settings.points.opacity, settings.sh_degree, self._device
        )
        self._objective: Objective = PhotometricObjective(settings.ssim_weight)
        self._optimizers = create_optimizers(self.parameters, settings, extent)
        self._density = DensityControl(settings.densification, extent)
        self._background = torch.tensor([settings.background], dtype=torch.float32, device=self._device)
        self._targets: dict[str, Target] = {}
        self._queue: list[int] = []
        self._view_count = 0

    @property
    def primitives(self) -> int:
        """Number of Gaussians."""
        return len(self.parameters["means"])

    @property
    def sh_degree(self) -> int:
        """Degree of the spherical harmonics in use."""
        return active_degree(self.settings, self.iteration)

    def learn_variance(self, rule: VarianceLearning) -> None:
        """Learn a log-variance for each Gaussian by ``rule``; only before the first step, and once.

        Raises:
            ValueError: it is too late, or variances are learned already.
        """
        if self.iteration or self._objective.parameters:
            raise ValueError("variances are learned from before the first step on, and by only one rule")
        self._objective = LikelihoodObjective(rule, self.settings.ssim_weight)
        extend_parameters(self.parameters, self._objective.parameters)
        self._optimizers = create_optimizers(self.parameters, self.settings, self.extent, self._objective.parameters)

    def fit(self, views: Views, iterations: int) -> None:
        """Optimise on ``views`` for ``iterations`` more steps, one view each.

        Views come in random order without repetition until all were used. When their number changes, a new order of all
        of them begins, so that a new view enters at once.

        Raises:
            UserError: parameters stopped being finite, or every Gaussian was pruned.
        """
        targets = self._prepared(views)
        for _ in range(iterations):
            if not self._queue:
                self._queue = [int(index) for index in self._generator.permutation(len(views))]
            index = self._queue.pop()
            self._step(targets[index], views.cameras[index])
            if self.iteration % CHECK_EVERY == 0 or not self.primitives:
                check_finite(self.parameters, self.iteration)
        check_finite(self.parameters, self.iteration)

    def render(self, cameras: Cameras) -> Rendering:
        """Render ``cameras``, which share one image size; depth is the expected depth, colours are clamped to 0..1.

        Raises:
            ValueError: the image sizes differ, or there is no camera.
        """
        return rendered(self.parameters, cameras, self.sh_degree, self._background)

    def copy(self, seed: int | None = None) -> GaussianSplats:
        """Return an independent copy that goes on with the same bits; photographs, which never change, are shared.

        With a ``seed`` it draws from a generator of its own, beginning with a new order of the views.
        """
        twin = copy.deepcopy(self, {id(target): target for target in self._targets.values()})
        if seed is not None:
            twin._generator, twin._queue = np.random.Generator(np.random.PCG64(seed)), []
        return twin

    def fisher_diagonal(self, cameras: Cameras, chain: str, parameters: Sequence[str]) -> Iterator[FisherInformation]:
        """Yield the diagonal Fisher information of one camera after another: see ``information.parameter_fisher``."""
        return parameter_fisher(self.parameters, cameras, self.sh_degree, self.settings.background, chain, parameters)

    def fisher_probes(
        self, cameras: Cameras, chain: str, parameters: Sequence[str], probes: int, seeds: Sequence[int]
    ) -> Iterator[FisherInformation]:
        """Yield estimates of the same: see ``probes.probe_views``."""
        return probe_views(self.parameters, cameras, self.sh_degree, self._background, chain, parameters, probes, seeds)

    @property
    def centres(self) -> npt.NDArray[np.float32]:
        """Positions of the Gaussians, ``[n, 3]``."""
        return np.asarray(self.parameters["means"].detach().cpu().numpy())

    def blended_values(self, camera: Cameras, values: npt.NDArray[np.float32]) -> FloatImages:
        """Return the image of one value per Gaussian: see ``blending_weights.blended_values``."""
        return blended_values(self.parameters, camera, values)

    def front_weights(self, camera: Cameras, image: FloatImages, transmittance: float) -> WeightSums:
        """Return each Gaussian's sum of weight times image: see ``blending_weights.front_weights``."""
        return front_weights(self.parameters, camera, image, transmittance)

    def variance_reduction(self, cameras: Cameras, rule: VarianceReduction) -> npt.NDArray[np.float64]:
        """Return the variance that each camera's view removes, ``[n]``: see ``variance.variance_reductions``.

        Raises:
            ValueError: no variance is learned.
        """
        if not isinstance(self._objective, LikelihoodObjective):
            raise ValueError("a reduction needs variances that are learned, and there is none")
        with torch.no_grad():
            variances = self.parameters[LOG_VARIANCES].exp()
        return variance_reductions(self.parameters, variances, cameras, self._objective.rule.attenuated, rule)

    def fingerprint(self) -> int:
        """Return a checksum of the parameters and of the generator's state: see ``training_state.checksum``."""
        return checksum(self.parameters, self._generator.bit_generator.state)

    def export(self, folder: Path) -> None:
        """Write ``splats.ply``, in the coordinates of the capture, to ``folder``: see ``ply.write_ply``."""
        write_ply(folder / "splats.ply", self.parameters, self.to_capture)

    def save(self, path: Path) -> None:
        """Write parameters, optimiser moments, density statistics, counters and the generator's state to ``path``."""
        tensors, adam_steps = optimizer_tensors(self.parameters, self._optimizers)
        tensors |= {f"density.{key}": value for key, value in self._density.statistics().items()}
        state = CheckpointState(
            settings=self.settings,
            extent=self.extent,
            to_capture=self.to_capture,
            iteration=self.iteration,
            adam_steps=adam_steps,
            queue=self._queue,
            view_count=self._view_count,
            generator=dict(self._generator.bit_generator.state),
        )
        write_checkpoint(path, tensors, state)

    def load(self, path: Path) -> None:
        """Restore what ``save`` wrote; further steps give the same bits as without interruption.

        Raises:
            UserError: the file cannot be read, or is of other settings or another scene.
        """
        tensors, state = read_checkpoint(path)
        names = (*NAMES, *self._objective.parameters)
        if set(state.adam_steps) != set(names):
            fault = f"has the parameters {', '.join(sorted(state.adam_steps))} instead of {', '.join(sorted(names))}"
            raise UserError(path, fault, "load it for the method that it was fitted for, or fit again")
        written = (state.settings, state.extent, state.to_capture)
        if written != (self.settings, self.extent, self.to_capture):
            raise UserError(path, "was written with other settings or for another scene", "fit again")
        tensors = {name: tensor.to(self._device) for name, tensor in tensors.items()}
        self.parameters = {name: torch.nn.Parameter(tensors[name]) for name in names}
        self._optimizers = create_optimizers(self.parameters, self.settings, self.extent, self._objective.parameters)
        restore_moments(self.parameters, self._optimizers, tensors, state.adam_steps)
        self._density.restore({key: tensors[f"density.{key}"] for key in STATISTICS if f"density.{key}" in tensors})
        self.iteration = state.iteration
        self._queue, self._view_count = list(state.queue), state.view_count
        self._generator.bit_generator.state = state.generator

    def _prepared(self, views: Views) -> list[Target]:
        """Return the photographs as the loss takes them, each converted once and kept under its name while it is used.

        Where the number of views changed, a new order of them begins.
        """
        known = self._targets
        self._targets = {
            name: known[name] if name in known else prepare_target(image, self._device)
            for name, image in zip(views.names, views.images, strict=True)
        }
        if len(views) != self._view_count:
            self._queue, self._view_count = [], len(views)
        return [self._targets[name] for name in views.names]

    def _step(self, target: Target, camera: Cameras) -> None:
        step = self.iteration + 1
        self._density.before_step(self.parameters, self._optimizers, step, self._generator)
        degree = follow_schedules(self._optimizers, self.settings, self.extent, step)
        absolute = self.settings.densification.absolute_gradient
        arguments = rasterizer_arguments(self.parameters, camera, degree, self._background, absolute=absolute)
        loss, meta = self._objective(self.parameters, arguments, target)
        self._density.before_backward(self.parameters, self._optimizers, step, meta)
        loss.backward()  # type: ignore[no-untyped-call]
        self._density.after_backward(step, meta)
        for optimizer in self._optimizers.values():
            optimizer.step()
            optimizer.zero_grad()
        self.iteration = step
