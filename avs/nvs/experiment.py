"""Puts an episode together: the scene, the reconstruction and the method that the settings name."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Literal

from avs.nvs.episode_settings import EpisodeSettings
from avs.nvs.evaluation import Evaluator
from avs.nvs.loop import Identity, Outcome, Plan, Progress, run
from avs.nvs.pictures import write_pictures
from avs.nvs.program import ListedViews, read_views
from avs.nvs.protocol import SCHEDULE, ProtocolSettings
from avs.nvs.record import Episode
from avs.nvs.schedule import initial_captures
from avs.representations import kinds
from avs.representations.base import Representation, RepresentationSettings
from avs.scene.cameras import IndexArray
from avs.scene.scene import Scene, read_scene
from avs.selection import registry
from avs.selection.contract import OWN_SCHEDULE, UNRANKED, Method, Resources, Settings
from avs.selection.session import Builder, preparing
from avs.system.devices import take_device
from avs.system.errors import UserError
from avs.system.files import file_hash
from avs.system.records import is_as_written, read_record, write_record
from avs.system.seeds import seed_global_generators, seed_of


def run_episode(
    scene_folder: Path,
    settings: EpisodeSettings,
    seed: int,
    weights: Path | None,
    out: Path,
    progress: Progress,
    views: Path | None = None,
    followed: Path | None = None,
) -> None:
    """Run one episode; write its two records, the model and the pictures that it keeps to the folder ``out``.

    Args:
        scene_folder: a scene, as ``avs.scene.scene`` writes it.
        settings: the method, the loop and the reconstruction.
        seed: seed of the reconstruction and of random choices.
        weights: checkpoint of the scorer that the method names, or None.
        out: folder of the results.
        progress: receives one line about each step.
        views: the choice of a method that is a program of its own (``avs.nvs.program.ViewList``), or None.
        followed: the episode of the method that ``Method.follows`` names, with the same scene and seed, or None.

    Raises:
        UserError: see ``avs.nvs.loop.run``; or the device, the weights or the followed episode is not there or does not
            fit.
    """
    take_device(settings.device)
    scene = read_scene(scene_folder)
    method = registry.find(settings.method).method if views is None else _program(settings.protocol, scene, views)
    if set(settings.own).intersection(SCHEDULE) and method.group not in UNRANKED:
        method = dataclasses.replace(method, group=OWN_SCHEDULE)
    seed_global_generators("method", scene.name, settings.method, seed)
    # A program reads its settings by itself; they are recorded as they are.
    checked = registry.create_settings(settings.method, settings.selector) if views is None else Settings()
    identity = Identity(
        method=settings.method,
        seed=seed,
        representation=settings.representation.model_dump(mode="json"),
        selector=settings.selector if views is not None else checked.model_dump(mode="json"),
        weights_hash=None if weights is None else file_hash(weights),
        weights_file=None if weights is None else weights.name,
        own=settings.own,
    )
    plan = Plan(
        scene=scene,
        protocol=settings.protocol,
        identity=identity,
        method=method,
        selector=(
            method.selector(checked, Resources(weights, settings.device))
            if method.follows is None
            else _following(settings.method, method.follows, scene, seed, followed)
        ),
        build=builder(scene, settings.representation, seed, settings.device),
        evaluate=Evaluator(scene, settings.protocol.lpips, settings.device),
        progress=lambda line: progress(f"{scene.name}, {method.label}, seed {seed}: {line}"),
        device=settings.device,
        pictures=settings.pictures,
    )
    _write(out, run(plan))


def replay_episode(
    scene_folder: Path, episode: Path, device: Literal["cpu", "cuda"], out: Path, progress: Progress
) -> None:
    """Run an episode again on the views that it selected, without its scores; the curve comes out the same.

    Args:
        scene_folder: the scene of the episode.
        episode: an ``episode.json``, possibly with another list of selected views, edited by hand.
        device: where to run.
        out: folder of the results, as in ``run_episode``.
        progress: receives one line about each step.

    Raises:
        UserError: the record is damaged, belongs to another scene, or selects a view that is not a candidate.
    """
    take_device(device)
    recorded = read_record(episode, Episode, "name the episode.json of a run, or a copy with other views", edited=True)
    what = "Replay of" if is_as_written(episode) else "Edited replay of"
    scene = read_scene(scene_folder)
    if scene.content_hash != recorded.scene_hash:
        raise UserError(episode, f"was recorded on another scene than {scene_folder}", "pass the scene it was run on")
    settings = kinds.create_settings(recorded.representation)
    protocol = ProtocolSettings.model_validate(recorded.protocol)
    _check_views(episode, recorded, [scene.names[index] for index in initial_captures(scene, protocol)])
    method = _listed(f"{what} {recorded.label}", recorded.group, episode, ListedViews(recorded.selected, episode))
    plan = Plan(
        scene=scene,
        protocol=protocol,
        identity=Identity("replay", recorded.seed, recorded.representation, selector={}),
        method=dataclasses.replace(method, chooses=recorded.chooses),
        selector=method.selector(Settings(), Resources()),
        build=_prepared(builder(scene, settings, recorded.seed, device), recorded, device),
        evaluate=Evaluator(scene, protocol.lpips, device),
        progress=lambda line: progress(f"{scene.name}, replay: {line}"),
        device=device,
    )
    _write(out, run(plan))


def _check_views(path: Path, recorded: Episode, initial: list[str]) -> None:
    """Refuse a record, edited by hand, whose views are not those that a replay would capture."""
    if recorded.initial != initial:
        fault = f"lists {', '.join(recorded.initial)} as initial, and its protocol begins with {', '.join(initial)}"
        raise UserError(path, fault, "leave `initial` as it is; `selected` alone can be edited")
    count = recorded.budget - len(initial)
    if len(recorded.selected) != count:
        fault = f"lists {len(recorded.selected)} selected views, and its budget of {recorded.budget} takes {count}"
        raise UserError(path, fault, f"list {count} views in `selected`")


def _following(method: str, other: str, scene: Scene, seed: int, episode: Path | None) -> ListedViews:
    """Return the selector that captures the views of another method's episode of the same scene and seed."""
    if episode is None:
        raise UserError(f"method {method}", f"captures the views of {other}", "pass --follow its episode.json")
    recorded = read_record(episode, Episode)
    wanted = {"method": other, "scene_hash": scene.content_hash, "seed": seed}
    for name, value in wanted.items():
        if getattr(recorded, name) != value:
            fault = f"has {name} {getattr(recorded, name)} instead of {value}"
            raise UserError(episode, fault, "pass the episode of the followed method with the same scene and seed")
    return ListedViews(recorded.selected, episode)


def _program(protocol: ProtocolSettings, scene: Scene, views: Path) -> Method:
    """Return the method that follows the list of views which a program wrote."""
    initial = [scene.names[index] for index in initial_captures(scene, protocol)]
    listed, selector = read_views(views, initial, {scene.names[index] for index in scene.pool})
    return _listed(listed.label, listed.group, views, selector)


def _listed(label: str, group: str, source: Path, selector: ListedViews) -> Method:
    """Return the metadata of a method that follows a list; it gives no scores, so that its direction says nothing."""
    return Method(label, group, f"The views that {source.name} lists.", "lowest", lambda settings, resources: selector)


def builder(scene: Scene, settings: RepresentationSettings, seed: int, device: str) -> Builder:
    """Return what builds the reconstruction; its seed leaves the method out: all start from the same state."""

    def make(captured: IndexArray) -> Representation:
        return kinds.build(scene, captured, settings, seed_of("reconstruction", scene.name, seed), device)

    return make


def _prepared(build: Builder, recorded: Episode, device: str) -> Builder:
    """Return ``build`` with what the recorded method did to each reconstruction before it was fitted, if anything.

    A method that needs weights is not asked: none of them changes the reconstruction, and the weights may be elsewhere.
    """
    registered = registry.methods().get(recorded.method)
    method = None if registered is None else registered.method
    if method is None or method.scorer is not None or method.pretrained or method.follows is not None:
        return build
    settings = registry.create_settings(recorded.method, recorded.selector)
    seed_global_generators("method", recorded.scene, recorded.method, recorded.seed)
    return preparing(build, method, method.selector(settings, Resources(device=device)))


def _write(out: Path, outcome: Outcome) -> None:
    """Write what an episode leaves; ``episode.json`` comes last, so that it vouches for the others."""
    outcome.representation.export(out)
    write_pictures(out, outcome.pictures)
    write_record(out / "episode.meta.json", outcome.meta)
    write_record(out / "episode.json", outcome.record)
