"""Training of the cross-reference network."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from torch.optim.swa_utils import update_bn

from avs.iqa.cross_reference.backbone_weights import find_weights, initial_weights
from avs.iqa.cross_reference.backbones import build_backbone, fused, open_residual_branches
from avs.iqa.cross_reference.distortions import Distortions, read_distortions
from avs.iqa.cross_reference.model_card import model_card
from avs.iqa.cross_reference.network import CrossReferenceNetwork, build_network
from avs.iqa.cross_reference.scorer_checkpoint import save_network
from avs.iqa.cross_reference.scorer_settings import ScorerSettings, TrainingSettings
from avs.iqa.cross_reference.training_batches import Batch, Sampler
from avs.iqa.cross_reference.training_checkpoint import load_training, save_training
from avs.iqa.cross_reference.training_facts import facts_of_card
from avs.iqa.cross_reference.training_loss import map_loss, predicted_maps
from avs.iqa.cross_reference.training_processes import Group, group_of
from avs.iqa.cross_reference.training_run import SECONDS_BETWEEN, LossPoint, TrainingRun
from avs.scene.images import pixel_hash
from avs.system.code_inputs import sources, stamp
from avs.system.devices import take_device
from avs.system.errors import UserError
from avs.system.files import canonical_json, write_json

Progress = Callable[[str], None]
"""Takes one line about the course of the training."""

CHECKPOINT = "training.safetensors"
"""Beside the model card while a training is not finished."""

_HELD_OUT_BATCHES = 4
_CALIBRATION_BATCHES = 8


def train(
    training: list[Path],
    held_out: list[Path],
    weights: Path,
    card: Path,
    settings: ScorerSettings,
    progress: Progress,
    device: str = "cpu",
) -> None:
    """Train a scorer and write its weights and its model card; one that was killed goes on from its last checkpoint.

    Args:
        training: distortion data of the scenes that train it.
        held_out: distortion data of other scenes, which only measure it.
        weights: file to write.
        card: model card (JSON) to write.
        settings: architecture, optimisation and seed.
        progress: receives one line at each evaluation, and one a minute.
        device: ``cpu`` or ``cuda``.

    Raises:
        UserError: see ``fit``; or a file is damaged, a held-out scene is also a training scene, or pretrained weights
            are demanded and absent.
    """
    take_device(device)
    source, checkpoint = backbone_source(settings), card.with_name(CHECKPOINT)
    files = [*training, *held_out, *([] if source is None else [source]), *map(Path, sources(__name__))]
    told = _Told(training, held_out, settings, source, device, checkpoint, _digest(settings, device, files))
    scenes, others = told.data()
    sets = settings.training.batch // settings.training.queries_per_set
    with group_of(settings.training.processes, sets, device, _help, told) as group:
        network, curve = fit(scenes, others, told, progress, group)
    content = model_card(network, settings, source, scenes, others, curve, device)
    save_network(weights, network, facts_of_card(content, is_frozen(settings.training, source)))
    write_json(card, content)
    checkpoint.unlink(missing_ok=True)


@dataclass(frozen=True)
class _Told:
    """What every process of a training is told."""

    training: list[Path]
    held_out: list[Path]
    settings: ScorerSettings
    source: Path | None
    device: str
    checkpoint: Path
    made_of: str

    @property
    def folder(self) -> Path:
        """Where there must be room for what a training keeps on disk."""
        return self.checkpoint.parent

    def data(self) -> tuple[list[Distortions], list[Distortions]]:
        """Read the training scenes and the held-out ones."""
        scenes = [read_distortions(path) for path in self.training]
        others = [read_distortions(path) for path in self.held_out]
        known = {pixel_hash(photograph) for scene in scenes for photograph in scene.photographs}
        shared = [scene.scene for scene in others if not known.isdisjoint(map(pixel_hash, scene.photographs))]
        if shared:
            raise UserError(f"scene {shared[0]}", "is both for training and held out", "choose other scenes")
        return scenes, others


def _help(group: Group, told: _Told) -> None:
    """Do the part of another process of the training."""
    fit(*told.data(), told, lambda _: None, group)


def _digest(settings: ScorerSettings, device: str, files: Iterable[Path]) -> str:
    """Return a digest of all that the course of a training depends on."""
    return f"{stamp(map(str, files))} {device} {canonical_json(settings.model_dump(mode='json'))}"


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
    scenes: list[Distortions], held_out: list[Distortions], told: _Told, progress: Progress, group: Group
) -> tuple[CrossReferenceNetwork, list[LossPoint]]:
    """Train a network on ``scenes``; the same data, settings and number of threads give the same bits on a CPU.

    A pretrained backbone is frozen, as CrossScore's is: its batch norms keep their statistics. A random one that is
    frozen gets the statistics of the training images first. A random one that is trained uses the statistics of each
    batch, queries and references together, and is evaluated with their running means.

    Args:
        scenes: distortion data to train on.
        held_out: distortion data that only measure the error on the way.
        told: settings, pretrained weights, device and the checkpoint to go on from.
        progress: receives one line at each evaluation, and one a minute.
        group: this process among those that train.

    Returns:
        The network in evaluation mode, and the course of the error.

    Raises:
        UserError: the error is not finite; or several processes share a backbone that is trained.
    """
    training = told.settings.training
    network = _initial(told.settings, told.source).to(told.device)
    frozen = is_frozen(training, told.source)
    if group.count > 1 and not frozen:
        fault = "share a backbone that is trained, whose batch norms would see a part of each batch"
        raise UserError("training.processes", fault, "set backbone_frozen: true, or processes: 1")
    features = _prepared_backbone(network, scenes, told) if frozen else None
    if not frozen and told.settings.network.standardized:
        _standardize(network, scenes, told)
    cached = features if training.cache_features else None
    sampler = Sampler(scenes, training, np.random.default_rng([told.settings.seed, 0]), cached, told.folder)
    examination = Sampler(held_out, training, np.random.default_rng([told.settings.seed, 1]), folder=told.folder)
    drawn = (examination.batch() for _ in range(_HELD_OUT_BATCHES))
    # a frozen backbone sees the same crops at each evaluation
    batches = [(batch if features is None else _encoded(batch, features)).to(told.device) for batch in drawn]
    run = TrainingRun(network, sampler, training, frozen, told.device, group)
    _run(run, batches, told, progress)
    return network.eval(), run.curve


def _run(run: TrainingRun, batches: list[Batch], told: _Told, progress: Progress) -> None:
    """Go on from the checkpoint, or begin, and train to the end."""
    steps, marks = run.settings.steps, run.settings.evaluations
    examined = {round(steps * (i + 1) / marks) for i in range(marks)}
    known = load_training(told.checkpoint, run, told.made_of)
    if known is not None:
        progress(known)
    run.begin_clocks()
    told_last = time.monotonic()
    while run.step < steps:
        run.advance()
        if run.step in examined:
            error = float(np.mean(run.recent))
            run.recent.clear()
            run.curve.append(LossPoint(run.step, error, _examine(run.network, batches)))
            held_out = run.curve[-1].held_out
            progress(f"step {run.step} of {steps}: error {error:.4f}, held out {held_out:.4f}; {run.pace()}")
        if time.monotonic() - told_last >= SECONDS_BETWEEN and run.step < steps and run.group.rank == 0:
            save_training(told.checkpoint, run, told.made_of)
            progress(f"step {run.step} of {steps}: {run.pace()}")
            told_last = time.monotonic()


@torch.inference_mode()
def _examine(network: CrossReferenceNetwork, batches: list[Batch]) -> float:
    network.eval()
    return float(np.mean([float(map_loss(predicted_maps(network, batch), batch.maps)) for batch in batches]))


def _initial(settings: ScorerSettings, source: Path | None) -> CrossReferenceNetwork:
    """Return a network with random weights, and with the backbone of ``source`` if there is one."""
    network = build_network(settings.network, settings.seed)
    if source is None:
        return network
    return network.with_backbone(build_backbone(settings.network, source))


def is_frozen(training: TrainingSettings, source: Path | None) -> bool:
    """Whether the backbone is left as it is: by the settings, else if and only if it is pretrained."""
    return source is not None if training.backbone_frozen is None else training.backbone_frozen


def _prepared_backbone(
    network: CrossReferenceNetwork, scenes: list[Distortions], told: _Told
) -> Callable[[Tensor], Tensor]:
    """Freeze the backbone, give it the statistics that it needs, and return what computes its features for good."""
    network.backbone.requires_grad_(False).eval()
    if told.source is None:
        _calibrate(network, scenes, told)
    if told.settings.network.standardized:
        _standardize(network, scenes, told)
    return _encoder(network, told.device)


def _calibrate(network: CrossReferenceNetwork, scenes: list[Distortions], told: _Told) -> None:
    """Give a random backbone's batch norms the statistics of training images; without them its features fade away."""
    open_residual_branches(network.backbone)
    with torch.no_grad():
        update_bn([network.normalized(batch) for batch in _images(scenes, told)], network.backbone)
    network.backbone.eval()


@torch.no_grad()
def _standardize(network: CrossReferenceNetwork, scenes: list[Distortions], told: _Told) -> None:
    """Give the network the means and deviations of its backbone's channels over training images."""
    network.backbone.eval()
    features = [network.features(batch).flatten(0, 2) for batch in _images(scenes, told)]
    network.standardize(torch.cat(features))


def _images(scenes: list[Distortions], told: _Told) -> Iterator[Tensor]:
    """Yield some batches of crops of renderings and photographs, the same at each call."""
    sampler = Sampler(scenes, told.settings.training, np.random.default_rng(0), folder=told.folder)
    for _ in range(_CALIBRATION_BATCHES):
        batch = sampler.batch().to(told.device)
        yield torch.cat([batch.queries.flatten(0, 1), batch.references.flatten(0, 2)])


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
        found = features(images.flatten(0, -4))
        return found.reshape(*images.shape[:-3], *found.shape[1:])

    return replace(batch, queries=encode(batch.queries), references=encode(batch.references))
