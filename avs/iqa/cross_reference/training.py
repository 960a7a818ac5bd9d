"""Training of the cross-reference network."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional
from torch.optim.swa_utils import update_bn

from avs.iqa.cross_reference.backbone_weights import find_weights, initial_weights
from avs.iqa.cross_reference.backbones import build_backbone, fused, open_residual_branches
from avs.iqa.cross_reference.distortions import Distortions, read_distortions
from avs.iqa.cross_reference.model_card import model_card
from avs.iqa.cross_reference.network import CrossReferenceNetwork, build_network
from avs.iqa.cross_reference.scorer_checkpoint import save_network
from avs.iqa.cross_reference.scorer_settings import ScorerSettings, TrainingSettings
from avs.iqa.cross_reference.training_batches import Batch, Sampler
from avs.iqa.cross_reference.training_facts import facts_of_card
from avs.scene.images import pixel_hash
from avs.system.devices import take_device
from avs.system.errors import UserError
from avs.system.files import write_json

Progress = Callable[[str], None]
"""Takes one line about the course of the training."""

_HELD_OUT_BATCHES = 4
_CALIBRATION_BATCHES = 8


@dataclass(frozen=True)
class LossPoint:
    """Mean absolute error of the predicted SSIM maps at one step."""

    step: int
    training: float
    held_out: float


def train(
    training: list[Path],
    held_out: list[Path],
    weights: Path,
    card: Path,
    settings: ScorerSettings,
    progress: Progress,
    device: str = "cpu",
) -> None:
    """Train a scorer and write its checkpoint and its model card.

    Args:
        training: distortion data of the scenes that train it.
        held_out: distortion data of other scenes, which only measure it.
        weights: checkpoint to write.
        card: model card (JSON) to write.
        settings: architecture, optimisation and seed.
        progress: receives one line at each evaluation.
        device: ``cpu`` or ``cuda``.

    Raises:
        UserError: a file is damaged, a held-out scene is also a training scene, or pretrained weights are demanded and
        absent.
    """
    take_device(device)
    scenes = [read_distortions(path) for path in training]
    others = [read_distortions(path) for path in held_out]
    known = {pixel_hash(photograph) for scene in scenes for photograph in scene.photographs}
    shared = [scene.scene for scene in others if not known.isdisjoint(map(pixel_hash, scene.photographs))]
    if shared:
        name = shared[0]
        raise UserError(f"scene {name}", "is both for training and held out", "choose other scenes")
    source = backbone_source(settings)
    network, curve = fit(scenes, others, settings, source, progress, device)
    content = model_card(network, settings, source, scenes, others, curve, device)
    save_network(weights, network, facts_of_card(content, is_frozen(settings.training, source)))
    write_json(card, content)


def backbone_source(settings: ScorerSettings) -> Path | None:
    """Return the file of the backbone's pretrained weights, or None to begin with random ones.

    Raises:
        UserError: the settings demand pretrained weights, and no local file has them.
    """
    training = settings.training
    if initial_weights(settings) is not None:
        return find_weights(settings.network.backbone, training.backbone_tag)
    if training.backbone_weights == "pretrained":
        name = ".".join(filter(None, (settings.network.backbone, training.backbone_tag)))
        raise UserError(name, "no local file of its pretrained weights", "fetch them, or set backbone_weights: auto")
    return None


def fit(
    scenes: list[Distortions],
    held_out: list[Distortions],
    settings: ScorerSettings,
    source: Path | None,
    progress: Progress,
    device: str = "cpu",
) -> tuple[CrossReferenceNetwork, list[LossPoint]]:
    """Train a network on ``scenes``; the same data, settings and number of threads give the same bits on a CPU.

    A pretrained backbone is frozen, as CrossScore's is: its batch norms keep their statistics. A random one that is
    frozen gets the statistics of the training images first. A random one that is trained uses the statistics of each
    batch, queries and references together, and is evaluated with their running means.

    Args:
        scenes: distortion data to train on.
        held_out: distortion data that only measure the error on the way.
        settings: architecture, optimisation and seed.
        source: pretrained weights of the backbone, or None for random ones.
        progress: receives one line at each evaluation.
        device: ``cpu`` or ``cuda``.

    Returns:
        The network in evaluation mode, and the course of the error.
    """
    training = settings.training
    network = _initial(settings, source).to(device)
    frozen = is_frozen(training, source)
    if frozen:
        network.backbone.requires_grad_(False).eval()
        if source is None:
            _calibrate(network, scenes, training, device)
    if settings.network.standardized:
        _standardize(network, scenes, training, device)
    features = _encoder(network, device) if frozen else None
    cached = features if training.cache_features else None
    sampler = Sampler(scenes, training, np.random.default_rng([settings.seed, 0]), cached)
    examination = Sampler(held_out, training, np.random.default_rng([settings.seed, 1]))
    drawn = (examination.batch() for _ in range(_HELD_OUT_BATCHES))
    # a frozen backbone sees the same crops at each evaluation
    batches = [(batch if features is None else _encoded(batch, features)).to(device) for batch in drawn]
    curve: list[LossPoint] = []
    for step, error in _optimise(network, sampler, training, frozen, device):
        curve.append(LossPoint(step, error, _examine(network, batches)))
        progress(f"step {step} of {training.steps}: error {error:.4f}, held out {curve[-1].held_out:.4f}")
    return network.eval(), curve


def _optimise(
    network: CrossReferenceNetwork, sampler: Sampler, training: TrainingSettings, frozen: bool, device: str
) -> Iterator[tuple[int, float]]:
    """Optimise ``network``; yield the step and the mean loss since the last time, when it is to be examined."""
    optimizer = torch.optim.AdamW(
        (parameter for parameter in network.parameters() if parameter.requires_grad), lr=training.learning_rate
    )
    schedule = torch.optim.lr_scheduler.LambdaLR(optimizer, lambda step: _rate(step, training))
    marks = {round(training.steps * (i + 1) / training.evaluations) for i in range(training.evaluations)}
    recent: list[float] = []
    for step in range(1, training.steps + 1):
        network.train()
        network.backbone.train(not frozen)
        batch = sampler.batch().to(device)
        predicted = predicted_maps(network, batch)
        error = functional.l1_loss(predicted, batch.maps)
        optimizer.zero_grad()
        total = error + training.centered * centered_loss(predicted, batch.maps) if training.centered else error
        total.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        schedule.step()
        recent.append(float(error.detach()))
        if not math.isfinite(recent[-1]):
            raise UserError(f"scorer at step {step}", "its error is not finite", "lower training.learning_rate")
        if step in marks:
            yield step, float(np.mean(recent))
            recent.clear()


def predicted_maps(network: CrossReferenceNetwork, batch: Batch) -> Tensor:
    """Return the predicted SSIM maps of a batch's queries, ``[s, q, crop, crop]``.

    The batch holds pixels, or features of the network's backbone.
    """
    sets, per_set = batch.queries.shape[:2]
    images = torch.cat([batch.queries.flatten(0, 1), batch.references.flatten(0, 1)])
    tokens = network.tokens(images) if batch.encoded else network.encode(images)
    queries, references = tokens[: sets * per_set], tokens[sets * per_set :]
    memory = network.memory(references.reshape(sets, -1, references.shape[-1]))
    absent = None
    if not bool(batch.present.all()):
        absent = (~batch.present).repeat_interleave(memory.shape[1] // batch.present.shape[1], dim=1)
    return network.predict(queries, memory, absent).view_as(batch.maps)


def loss(network: CrossReferenceNetwork, batch: Batch) -> Tensor:
    """Return the mean absolute error of the predicted SSIM maps, CrossScore's training loss."""
    return functional.l1_loss(predicted_maps(network, batch), batch.maps)


def centered_loss(predicted: Tensor, true: Tensor) -> Tensor:
    """Return the mean absolute error of scores less the mean of their set.

    The queries of a set are renderings of one moment. What it adds to the loss of maps is the order among them, which a
    choice depends on; nine tenths of the variance of scores lie between moments.

    Args:
        predicted: maps ``[s, q, crop, crop]``.
        true: likewise.
    """
    scores, truth = predicted.mean(dim=(2, 3)), true.mean(dim=(2, 3))
    return functional.l1_loss(scores - scores.mean(dim=1, keepdim=True), truth - truth.mean(dim=1, keepdim=True))


@torch.inference_mode()
def _examine(network: CrossReferenceNetwork, batches: list[Batch]) -> float:
    network.eval()
    return float(np.mean([float(loss(network, batch)) for batch in batches]))


def _initial(settings: ScorerSettings, source: Path | None) -> CrossReferenceNetwork:
    """Return a network with random weights, and with the backbone of ``source`` if there is one."""
    network = build_network(settings.network, settings.seed)
    if source is None:
        return network
    return network.with_backbone(build_backbone(settings.network, source))


def is_frozen(training: TrainingSettings, source: Path | None) -> bool:
    """Whether the backbone is left as it is: by the settings, else if and only if it is pretrained."""
    return source is not None if training.backbone_frozen is None else training.backbone_frozen


def _calibrate(
    network: CrossReferenceNetwork, scenes: list[Distortions], training: TrainingSettings, device: str
) -> None:
    """Give a random backbone's batch norms the statistics of training images; without them its features fade away."""
    open_residual_branches(network.backbone)
    with torch.no_grad():
        update_bn([network.normalized(batch) for batch in _images(scenes, training, device)], network.backbone)
    network.backbone.eval()


@torch.no_grad()
def _standardize(
    network: CrossReferenceNetwork, scenes: list[Distortions], training: TrainingSettings, device: str
) -> None:
    """Give the network the means and deviations of its backbone's channels over training images."""
    network.backbone.eval()
    features = [network.features(batch).flatten(0, 2) for batch in _images(scenes, training, device)]
    network.standardize(torch.cat(features))


def _images(scenes: list[Distortions], training: TrainingSettings, device: str) -> Iterator[Tensor]:
    """Yield some batches of crops of renderings and photographs, the same at each call."""
    sampler = Sampler(scenes, training, np.random.default_rng(0))
    for _ in range(_CALIBRATION_BATCHES):
        batch = sampler.batch().to(device)
        yield torch.cat([batch.queries.flatten(0, 1), batch.references.flatten(0, 1)])


def _encoder(network: CrossReferenceNetwork, device: str) -> Callable[[Tensor], Tensor]:
    """Return what computes the features of images for good, as fast as at inference."""
    merged = network.with_backbone(fused(network.backbone))

    @torch.no_grad()
    def features(images: Tensor) -> Tensor:
        return merged.features(images.to(device)).cpu()

    return features


def _encoded(batch: Batch, features: Callable[[Tensor], Tensor]) -> Batch:
    """Return a batch of pixels as one of features."""

    def encode(images: Tensor) -> Tensor:
        found = features(images.flatten(0, 1))
        return found.reshape(*images.shape[:2], *found.shape[1:])

    return replace(batch, queries=encode(batch.queries), references=encode(batch.references))


def _rate(step: int, training: TrainingSettings) -> float:
    """Return the factor of the learning rate after ``step`` steps."""
    if step < training.warmup:
        return (step + 1) / training.warmup
    if training.schedule == "constant":
        return 1.0
    return 0.5 * (1.0 + math.cos(math.pi * (step - training.warmup) / max(1, training.steps - training.warmup)))
