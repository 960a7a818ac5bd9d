"""A training under way, one step after another, alone or shared among processes."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

import torch

from avs.iqa.cross_reference.network import CrossReferenceNetwork
from avs.iqa.cross_reference.scorer_settings import TrainingSettings
from avs.iqa.cross_reference.training_batches import Sampler
from avs.iqa.cross_reference.training_loss import centered_loss, map_loss, predicted_maps
from avs.iqa.cross_reference.training_processes import ALONE, Group
from avs.system.errors import UserError

# The most between two lines about the course of a training, and between two checkpoints.
SECONDS_BETWEEN = 60.0


@dataclass(frozen=True)
class LossPoint:
    """Mean absolute error of the predicted SSIM maps at one step."""

    step: int
    training: float
    held_out: float


@dataclass
class TrainingRun:
    """All that goes on from one step to the next.

    Attributes:
        network: what is trained.
        sampler: draws the batches, the same in every process.
        settings: of the optimisation.
        frozen: whether the backbone is left as it is.
        device: ``cpu`` or ``cuda``.
        group: the processes that share each step.
        step: steps that are done.
        recent: the error of each step since the last point of the curve.
        curve: the course of the error.
    """

    network: CrossReferenceNetwork
    sampler: Sampler
    settings: TrainingSettings
    frozen: bool
    device: str
    group: Group = ALONE
    step: int = 0
    recent: list[float] = field(default_factory=list)
    curve: list[LossPoint] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Set up AdamW, and the clocks, which count this process alone."""
        self.trained = [parameter for parameter in self.network.parameters() if parameter.requires_grad]
        self.optimizer = torch.optim.AdamW(self.trained, lr=self.settings.learning_rate)
        self._started, self._begun_at, self._waited = time.monotonic(), self.step, 0.0

    def begin_clocks(self) -> None:
        """Let what ``pace`` tells count from here."""
        self._started, self._begun_at, self._waited = time.monotonic(), self.step, 0.0

    def advance(self) -> None:
        """Do one step.

        Raises:
            UserError: the error is not finite.
        """
        for group in self.optimizer.param_groups:
            group["lr"] = self.settings.learning_rate * rate(self.step, self.settings)
        self.network.train()
        self.network.backbone.train(not self.frozen)
        start = time.monotonic()
        batch = self.group.share(self.sampler.batch()).to(self.device)
        self._waited += time.monotonic() - start
        with torch.autocast(self.device, torch.bfloat16, enabled=self.settings.precision == "bfloat16"):
            predicted = predicted_maps(self.network, batch)
        predicted = predicted.float()
        error = map_loss(predicted, batch.maps)
        centered = self.settings.centered
        total = error + centered * centered_loss(predicted, batch.maps) if centered else error
        self.optimizer.zero_grad()
        (total * self.group.weight).backward()  # type: ignore[no-untyped-call]
        self.group.add_gradients(self.trained)
        self.optimizer.step()
        self.step += 1
        self.recent.append(self.group.added(float(error.detach()) * self.group.weight))
        if not math.isfinite(self.recent[-1]):
            raise UserError(f"scorer at step {self.step}", "its error is not finite", "lower training.learning_rate")

    def pace(self) -> str:
        """Return the share of the time that this process has waited for data, and how long the rest will take."""
        passed = max(time.monotonic() - self._started, 1e-9)
        left = passed / max(self.step - self._begun_at, 1) * (self.settings.steps - self.step)
        minutes, seconds = divmod(round(left), 60)
        return f"{self._waited / passed:.0%} of the time for data, {minutes}:{seconds:02d} left"


def rate(step: int, training: TrainingSettings) -> float:
    """Return the factor of the learning rate after ``step`` steps."""
    if step < training.warmup:
        return (step + 1) / training.warmup
    if training.schedule == "constant":
        return 1.0
    return 0.5 * (1.0 + math.cos(math.pi * (step - training.warmup) / max(1, training.steps - training.warmup)))
