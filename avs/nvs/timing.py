"""Times the selections of one method on a reconstruction that is the same for all methods."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import torch

from avs.nvs.experiment import builder
from avs.nvs.loop import Progress
from avs.nvs.schedule import capped_budget, initial_captures, selection_number
from avs.nvs.timing_record import Runtime, SelectionTimes
from avs.nvs.timing_settings import StateSettings, TimingSettings
from avs.representations import kinds
from avs.scene.cameras import IndexArray
from avs.scene.scene import Scene, read_scene
from avs.selection import registry
from avs.selection.contract import Method, PreparesRepresentation, Resources, Selector, State
from avs.selection.session import Builder, Session, preparing, timed_selection
from avs.system import provenance
from avs.system.devices import take_device
from avs.system.machine_load import LoadMeter
from avs.system.records import write_record
from avs.system.seeds import seed_global_generators, seed_of


def write_state(scene_folder: Path, settings: StateSettings, out: Path) -> None:
    """Fit the reconstruction on which methods are timed and write its checkpoint to ``out``.

    Its views are those of farthest-view sampling, which begins with the initial views; it follows the schedule of the
    loop up to the selection that has as many views as ``settings.runtime.views``.

    Raises:
        UserError: the device is not there, or the scene is damaged or too small.
    """
    take_device(settings.device)
    scene = read_scene(scene_folder)
    _fitted(scene, settings, _builder(scene, settings)).representation.save(out)


def time_method(
    scene_folder: Path, state: Path, settings: TimingSettings, weights: Path | None, out: Path, progress: Progress
) -> None:
    """Time the selections of a method and write the record to ``out``.

    A method that changes the optimisation of the reconstruction is timed on one that was fitted its way.

    Args:
        scene_folder: a scene, as ``avs.scene`` writes it.
        state: the checkpoint of ``write_state``.
        settings: the method, and what is timed.
        weights: checkpoint of the scorer that the method names, or None.
        out: the record.
        progress: receives one line about each selection.

    Raises:
        UserError: the device, the weights or the checkpoint is not there or does not fit.
    """
    started = provenance.now()
    take_device(settings.device)
    method = registry.find(settings.method).method
    checked = registry.create_settings(settings.method, settings.selector)
    scene = read_scene(scene_folder)
    seed_global_generators("method", scene.name, settings.method)
    selector = method.selector(checked, Resources(weights, settings.device))
    own_fit = isinstance(selector, PreparesRepresentation)
    build = preparing(_builder(scene, settings), method, selector)
    session = _fitted(scene, settings, build) if own_fit else _loaded(scene, settings, build, state)
    provenance.reset_peak_memory(settings.device)
    chosen = min(settings.views_per_step, len(session.candidates))
    selections, load = [], LoadMeter()
    for times in _timed(method, selector, session, settings, chosen):
        selections.append(times)
        progress(f"{scene.name}, {method.label}: {times.total_seconds:.3f} s")
    other_cores = load.others()
    record = Runtime(
        scene=scene.name,
        scene_hash=scene.content_hash,
        method=settings.method,
        label=method.label,
        group=method.group,
        selector=checked.model_dump(mode="json"),
        seed=settings.runtime.seed,
        iteration=session.iteration,
        primitives=session.representation.primitives,
        own_fit=own_fit,
        captured=len(session.captured),
        candidates=len(session.candidates),
        chosen=chosen,
        image_sizes=sorted(set(map(tuple, scene.cameras[session.candidates].sizes.tolist())), key=math.prod),
        selections=selections,
        peak_memory_bytes=provenance.peak_memory(settings.device),
        device=settings.device,
        computed_on=device_of(settings, registry.needed(settings.method, checked)),
        other_cores=other_cores,
        machine=provenance.machine(settings.device),
        threads=torch.get_num_threads(),
        packages=provenance.packages(),
        revision=provenance.revision(),
        started=started,
        finished=provenance.now(),
    )
    write_record(out, record)


def device_of(settings: TimingSettings, needs: Sequence[str]) -> str:
    """Return the device on which a method computes that needs these capabilities."""
    return "cpu" if kinds.find(settings.representation.kind).on_cpu.intersection(needs) else settings.device


def _timed(
    method: Method, selector: Selector, session: Session, settings: TimingSettings, k: int
) -> Iterator[SelectionTimes]:
    """Yield the times of one selection of ``k`` views after another.

    Before each of them the method selects without the photographs captured last. The first of these calls is the
    warm-up; all of them leave a method that remembers what it computed of photographs in the state in which it is in
    an episode, where one selection's photographs are new to the next.
    """
    device, start = settings.device, provenance.clock(settings.device)

    def state(number: int, without: int) -> State:
        rng = np.random.default_rng(seed_of("runtime", session.scene.name, settings.method, number))
        step = selection_number(settings.protocol, len(session.captured) - without, k)
        return session.state(rng, step, method.oracle, without)

    for repeat in range(settings.runtime.repeats):
        if repeat and provenance.clock(device) - start > settings.runtime.seconds:
            return
        timed_selection(method, selector, state(2 * repeat, without=k), k, device)
        timed = timed_selection(method, selector, state(2 * repeat + 1, without=0), k, device)
        yield SelectionTimes(
            render_seconds=timed.render_seconds,
            score_seconds=timed.score_seconds,
            total_seconds=timed.total_seconds,
        )


def _captured(scene: Scene, settings: StateSettings) -> IndexArray:
    """Return the indices of the captured views, in the order of farthest-view sampling."""
    protocol = settings.protocol
    budget, _ = capped_budget(protocol, len(scene.pool), scene.name)
    return initial_captures(scene, protocol, max(min(settings.runtime.views, budget - 1), protocol.initial_views))


def _iterations(scene: Scene, settings: StateSettings) -> tuple[int, ...]:
    """Return the iterations at which the loop selects, up to the selection that is timed."""
    protocol = settings.protocol
    added = len(_captured(scene, settings)) - protocol.initial_views
    return protocol.additions[: 1 + -(-added // protocol.views_per_step)]


def _builder(scene: Scene, settings: StateSettings) -> Builder:
    return builder(scene, settings.representation, settings.runtime.seed, settings.device)


def _begun(scene: Scene, settings: StateSettings, build: Builder) -> Session:
    initial = _captured(scene, settings)[: settings.protocol.initial_views]
    return Session(scene, build, initial, settings.device)


def _loaded(scene: Scene, settings: StateSettings, build: Builder, state: Path) -> Session:
    """Return the moment that is timed, on the reconstruction that ``write_state`` wrote."""
    session = _begun(scene, settings, build)
    session.representation.load(state)
    session.iteration = _iterations(scene, settings)[-1]
    session.capture(_captured(scene, settings)[len(session.captured) :])
    return session


def _fitted(scene: Scene, settings: StateSettings, build: Builder) -> Session:
    """Return the moment that is timed, on a reconstruction of ``build`` that was fitted up to there."""
    session = _begun(scene, settings, build)
    captured = _captured(scene, settings)
    for iteration in _iterations(scene, settings):
        session.fit_until(iteration)
        done = len(session.captured)
        session.capture(captured[done : done + settings.protocol.views_per_step])
    return session
