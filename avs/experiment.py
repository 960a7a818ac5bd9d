"""Puts an episode together: the scene, the reconstruction and the method that the settings name."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from avs import selectors
from avs.cameras import IndexArray
from avs.episode import Builder, Identity, Plan, Progress, run, seed_of
from avs.errors import UserError
from avs.evaluation import Evaluator
from avs.files import file_hash
from avs.protocol import ProtocolSettings
from avs.record import Episode, read_record, write_record
from avs.representations.base import Representation
from avs.representations.gaussians.ply import write_ply
from avs.representations.gaussians.settings import GaussianSettings
from avs.representations.gaussians.splats import GaussianSplats, build
from avs.scene import Scene, read_scene
from avs.selectors.base import Resources, Selection, State


class EpisodeSettings(BaseModel):
    """What an episode reads of the configuration."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    method: str = Field(description="identifier of the selection method")
    device: Literal["cpu", "cuda"] = Field(description="where the reconstruction and networks run")
    protocol: ProtocolSettings = Field(description="the loop")
    representation: GaussianSettings = Field(description="the reconstruction")
    selector: dict[str, Any] = Field(description="settings of the method")


def run_episode(
    scene_folder: Path, settings: EpisodeSettings, seed: int, weights: Path | None, out: Path, progress: Progress
) -> None:
    """Run one episode and write ``episode.json``, ``episode.meta.json`` and ``splats.ply`` to the folder ``out``.

    Args:
        scene_folder: a scene, as ``avs.scene`` writes it.
        settings: the method, the loop and the reconstruction.
        seed: seed of the reconstruction and of random choices.
        weights: checkpoint of the scorer that the method names, or None.
        out: folder of the results.
        progress: is told one line about each step.

    Raises:
        UserError: see ``avs.episode.run``; or the device or the weights are not there.
    """
    check_device(settings.device)
    method = selectors.find(settings.method).method
    if method.scorer is not None and weights is None:
        raise UserError(settings.method, f"needs the weights of the scorer {method.scorer}", "pass --weights")
    selector_settings = selectors.create_settings(settings.method, settings.selector)
    scene = read_scene(scene_folder)
    identity = Identity(
        method=settings.method,
        label=method.label,
        group=method.group,
        higher_is_worse=method.higher_is_worse,
        seed=seed,
        representation=settings.representation.model_dump(mode="json"),
        selector=selector_settings.model_dump(mode="json"),
        weights_hash=None if weights is None else file_hash(weights),
    )
    plan = Plan(
        scene=scene,
        protocol=settings.protocol,
        identity=identity,
        selector=method.build(selector_settings, Resources(weights, settings.device)),
        build=_builder(scene, settings.representation, seed, settings.device),
        evaluate=Evaluator(scene, settings.protocol.lpips, settings.device),
        progress=lambda line: progress(f"{scene.name}, {method.label}, seed {seed}: {line}"),
        device=settings.device,
        oracle=method.oracle,
    )
    _write(out, *run(plan))


def replay_episode(
    scene_folder: Path, episode: Path, device: Literal["cpu", "cuda"], out: Path, progress: Progress
) -> None:
    """Run an episode again on the views that it selected, without its method; the curve comes out the same.

    Args:
        scene_folder: the scene of the episode.
        episode: an ``episode.json``, possibly with another list of selected views, edited by hand.
        device: where to run.
        out: folder of the results, as in ``run_episode``.
        progress: is told one line about each step.

    Raises:
        UserError: the record is damaged, belongs to another scene, or selects a view that is not a candidate.
    """
    check_device(device)
    recorded = read_record(episode, Episode)
    scene = read_scene(scene_folder)
    if scene.content_hash != recorded.scene_hash:
        raise UserError(episode, f"was recorded on another scene than {scene_folder}", "pass the scene it was run on")
    settings = GaussianSettings.model_validate(recorded.representation)
    protocol = ProtocolSettings.model_validate(recorded.protocol)
    plan = Plan(
        scene=scene,
        protocol=protocol,
        identity=Identity(
            method="replay",
            label=f"Replay of {recorded.label}",
            group=recorded.group,
            higher_is_worse=recorded.higher_is_worse,
            seed=recorded.seed,
            representation=recorded.representation,
            selector={},
        ),
        selector=_Replay(scene, recorded, episode),
        build=_builder(scene, settings, recorded.seed, device),
        evaluate=Evaluator(scene, protocol.lpips, device),
        progress=lambda line: progress(f"{scene.name}, replay: {line}"),
        device=device,
    )
    _write(out, *run(plan))


def check_device(device: str) -> None:
    """Refuse ``cuda`` where there is no GPU that torch can use.

    Raises:
        UserError: there is none.
    """
    import torch

    if device == "cuda" and not torch.cuda.is_available():
        raise UserError("device cuda", "torch finds no GPU here", "set device: cpu, or run where there is one")


def _builder(scene: Scene, settings: GaussianSettings, seed: int, device: str) -> Builder:
    """Return what builds the reconstruction; its seed leaves the method out, so that all methods start alike."""

    def builder(captured: IndexArray) -> Representation:
        return build(scene, captured, settings, seed_of("reconstruction", scene.name, seed), device)

    return builder


def _write(out: Path, record: Episode, meta: BaseModel, representation: Representation) -> None:
    """Write the reconstruction and both records; ``episode.json`` comes last, so that it vouches for the others."""
    if isinstance(representation, GaussianSplats):
        write_ply(out / "splats.ply", representation.parameters)
    write_record(out / "episode.meta.json", meta)
    write_record(out / "episode.json", record)


class _Replay:
    """Selects the views that a record lists, step by step."""

    def __init__(self, scene: Scene, recorded: Episode, source: Path) -> None:
        self._candidates = [scene.names[index] for index in scene.pool if scene.names[index] not in recorded.initial]
        self._waiting = list(recorded.selected)
        self._source = source

    def select(self, state: State, k: int) -> Selection:
        """Return the next ``k`` listed views."""
        names, self._waiting = self._waiting[:k], self._waiting[k:]
        if len(names) < k:
            raise UserError(
                self._source, f"lists too few views at step {state.step}", "list as many as the budget asks"
            )
        unknown = [name for name in names if name not in self._candidates]
        if unknown:
            raise UserError(
                self._source, f"{unknown[0]} is not a candidate at step {state.step}", "mend the list of views"
            )
        rows = np.array([self._candidates.index(name) for name in names], dtype=np.int64)
        self._candidates = [name for name in self._candidates if name not in names]
        return Selection(rows, None)
