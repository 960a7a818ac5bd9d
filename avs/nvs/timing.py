"""Times the selections of one method on a reconstruction that is the same for all methods."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch

from avs.nvs.experiment import builder, check_device
from avs.nvs.loop import Progress, capped_budget
from avs.nvs.timing_record import Runtime, SelectionTimes
from avs.nvs.timing_settings import StateSettings, TimingSettings
from avs.representations.base import Representation
from avs.scene.cameras import IndexArray
from avs.scene.sampling import initial_views
from avs.scene.scene import Scene, read_scene
from avs.selection import registry
from avs.selection.contract import Method, PreparesRepresentation, Resources, Selector, State, Truth
from avs.system import provenance
from avs.system.records import write_record
from avs.system.seeds import seed_of


def write_state(scene_folder: Path, settings: StateSettings, out: Path) -> None:
    """Fit the reconstruction on which methods are timed and write its checkpoint to ``out``.

    Its views are those of farthest-view sampling, which begins with the initial views; it follows the schedule of the
    loop up to the selection that has as many views as ``settings.runtime.views``.

    Raises:
        UserError: the device is not there, or the scene is damaged or too small.
    """
    check_device(settings.device)
    _fitted(read_scene(scene_folder), settings, None).save(out)


def time_method(
    scene_folder: Path, state: Path, settings: TimingSettings, weights: Path | None, out: Path, progress: Progress
) -> None:
    """Time the selections of a method and write the record to ``out``.

    A method that changes the optimisation of the reconstruction is timed on one that was fitted its way.

    Args:
        scene_folder: a scene, as ``avs.scene.scene`` writes it.
        state: the checkpoint of ``write_state``.
        settings: the method, and what is timed.
        weights: checkpoint of the scorer that the method names, or None.
        out: the record.
        progress: is told one line about each selection.

    Raises:
        UserError: the device, the weights or the checkpoint is not there or does not fit.
    """
    started = provenance.now()
    check_device(settings.device)
    method = registry.find(settings.method).method
    checked = registry.create_settings(settings.method, settings.selector)
    scene = read_scene(scene_folder)
    selector = method.selector(checked, Resources(weights, settings.device))
    preparing = selector if isinstance(selector, PreparesRepresentation) else None
    if preparing is None:
        representation = _built(scene, settings)
        representation.load(state)
    else:
        representation = _fitted(scene, settings, preparing)
    provenance.reset_peak_memory(settings.device)
    moment = _Moment(scene, settings, method, representation)
    selections = []
    for times in _timed(selector, moment):
        selections.append(times)
        progress(f"{scene.name}, {method.label}: {times.total_seconds:.3f} s")
    record = Runtime(
        scene=scene.name,
        scene_hash=scene.content_hash,
        method=settings.method,
        label=method.label,
        group=method.group,
        selector=checked.model_dump(mode="json"),
        seed=settings.runtime.seed,
        iteration=_iterations(scene, settings)[-1],
        primitives=representation.primitives,
        own_fit=preparing is not None,
        captured=len(moment.captured),
        candidates=len(moment.candidates),
        chosen=moment.chosen,
        image_size=tuple(scene.cameras[moment.candidates].sizes.max(axis=0).tolist()),
        selections=selections,
        peak_memory_bytes=provenance.peak_memory(settings.device),
        device=settings.device,
        machine=provenance.machine(settings.device),
        threads=torch.get_num_threads(),
        packages=provenance.packages(),
        revision=provenance.revision(),
        started=started,
        finished=provenance.now(),
    )
    write_record(out, record)


class _Moment:
    """The situation in which a method is timed."""

    def __init__(self, scene: Scene, settings: TimingSettings, method: Method, representation: Representation) -> None:
        self.scene, self.settings, self.representation = scene, settings, representation
        self.captured = _captured(scene, settings)
        self.candidates = np.setdiff1d(scene.pool, self.captured)
        self.chosen = min(settings.views_per_step, len(self.candidates))
        self._views = scene.views(self.captured)
        self._truth = Truth(scene.views(self.candidates), scene.views(scene.test)) if method.oracle else None

    def state(self, lacking: int, step: int) -> State:
        """Return what the method may look at, without the ``lacking`` photographs captured last."""
        rng = np.random.default_rng(seed_of("runtime", self.scene.name, self.settings.method, step))
        rows = np.arange(max(1, len(self.captured) - lacking))
        return State(
            self.representation, self._views[rows], self.scene.cameras[self.candidates], rng, step, self._truth
        )


def _timed(selector: Selector, moment: _Moment) -> Iterator[SelectionTimes]:
    """Yield the times of one selection after another.

    Before each of them the method selects without the photographs captured last. The first of these calls is the
    warm-up; all of them leave a method that remembers what it computed of photographs in the state in which it is in
    an episode, where one selection's photographs are new to the next.
    """
    settings = moment.settings
    device, start = settings.device, provenance.clock(settings.device)
    for repeat in range(settings.runtime.repeats):
        if repeat and provenance.clock(device) - start > settings.runtime.seconds:
            return
        selector.select(moment.state(moment.chosen, 2 * repeat), moment.chosen)
        state = moment.state(0, 2 * repeat + 1)
        begin = provenance.clock(device)
        selection = selector.select(state, moment.chosen)
        total = provenance.clock(device) - begin
        yield SelectionTimes(
            render_seconds=selection.render_seconds,
            score_seconds=total - selection.render_seconds,
            total_seconds=total,
        )


def _captured(scene: Scene, settings: StateSettings) -> IndexArray:
    """Return the indices of the captured views, in the order of farthest-view sampling."""
    pool, protocol = scene.pool, settings.protocol
    budget, _ = capped_budget(protocol, len(pool), scene.name)
    count = max(min(settings.runtime.views, budget - 1), protocol.initial_views)
    return pool[initial_views(scene.cameras[pool].centers, count, protocol.initial_start)]


def _iterations(scene: Scene, settings: StateSettings) -> tuple[int, ...]:
    """Return the iterations at which the loop selects, up to the selection that is timed."""
    protocol = settings.protocol
    added = len(_captured(scene, settings)) - protocol.initial_views
    return protocol.additions[: 1 + -(-added // protocol.views_per_step)]


def _built(scene: Scene, settings: StateSettings) -> Representation:
    initial = _captured(scene, settings)[: settings.protocol.initial_views]
    return builder(scene, settings.representation, settings.runtime.seed, settings.device)(initial)


def _fitted(scene: Scene, settings: StateSettings, preparing: PreparesRepresentation | None) -> Representation:
    """Return the reconstruction at the moment that is timed, prepared by ``preparing``."""
    representation = _built(scene, settings)
    if preparing is not None:
        preparing.prepare(representation)
    protocol, done = settings.protocol, 0
    views = scene.views(_captured(scene, settings))
    for step, iteration in enumerate(_iterations(scene, settings)):
        count = min(protocol.initial_views + step * protocol.views_per_step, len(views))
        representation.fit(views[np.arange(count)], iteration - done)
        done = iteration
    return representation
