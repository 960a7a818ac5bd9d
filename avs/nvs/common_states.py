"""All methods score the same candidates of the same reconstructions, beside what the hidden photographs say of them.

In an episode each method scores the candidates that its own choices have left, at states that they led to. Here one
reconstruction follows an order of capture that is no method's, and at several moments every method gets the same bits
of it. What differs between two methods' rank correlations with the truth is then the score alone.
"""

from __future__ import annotations

import textwrap
import traceback
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avs.nvs.common_states_record import CommonState, CommonStates, ScoredMethod
from avs.nvs.common_states_settings import CommonStatesJob, CommonStatesSettings, ScoredMethodSettings
from avs.nvs.experiment import builder
from avs.nvs.loop import Progress
from avs.nvs.schedule import capped_budget, initial_captures, selection_number, selections
from avs.representations.capabilities import Copyable
from avs.scene.cameras import IndexArray
from avs.scene.photographs import Photographs
from avs.scene.scene import Scene, read_scene
from avs.selection import registry
from avs.selection.choice import notes_of, select_views
from avs.selection.contract import Method, PreparesRepresentation, Resources, Selector, State
from avs.selection.session import Builder, Session, preparing
from avs.selection.truth import gains, sample, true_metrics
from avs.selection.untouched import untouched
from avs.system.computed_by import write_computed_by
from avs.system.devices import take_device
from avs.system.errors import UserError
from avs.system.files import file_hash, temporary_folder
from avs.system.provenance import clock
from avs.system.records import write_record
from avs.system.seeds import seed_global_generators, seed_of

MEASUREMENTS = 2
"""How often a gain is measured: the correlation between two measurements tells how much of it is noise."""


def write_common_states(
    scene_folder: Path,
    settings: CommonStatesJob,
    seed: int,
    weights: Mapping[str, Path],
    out: Path,
    progress: Progress,
) -> None:
    """Measure the truth at the common states of a scene, let every method score them, and write the record to ``out``.

    What it was computed with goes beside it, to ``*.meta.json``.

    A method that fails leaves the others as they are: the record has the reason in the place of its scores.

    Args:
        scene_folder: a scene, as ``avs.scene.scene`` writes it.
        settings: the states, the reconstruction and the methods.
        seed: of the reconstruction, the order of capture and random choices.
        weights: checkpoints by identifier, of the methods that need one.
        out: the record.
        progress: receives one line about each state and each method.

    Raises:
        UserError: the device is not there, or the scene is damaged or too small.
    """
    take_device(settings.device)
    scene = read_scene(scene_folder)
    with temporary_folder("avs-states-") as folder:
        states = _States(scene, settings, seed, folder, progress)
        measured = states.measure()
        methods = [states.scored(each, weights.get(each.method)) for each in settings.methods]
    record = CommonStates(
        scene=scene.name,
        dataset=scene.dataset,
        scene_hash=scene.content_hash,
        seed=seed,
        protocol=settings.protocol.model_dump(mode="json"),
        representation=settings.representation.model_dump(mode="json"),
        settings=settings.common_states.model_dump(mode="json"),
        captured=[scene.names[row] for row in states.order[: states.moments[-1].views]],
        device=settings.device,
        notes=states.notes,
        states=measured,
        methods=methods,
    )
    write_record(out, record)
    write_computed_by(out, settings.device)


@dataclass(frozen=True)
class Moment:
    """When candidates are scored: the number of captured views, and the optimisation steps done."""

    views: int
    iteration: int


def moments_of(scene: Scene, settings: CommonStatesJob) -> list[Moment]:
    """Return the selections of an episode that are nearest to the numbers of views asked for, each once."""
    budget, _ = capped_budget(settings.protocol, len(scene.pool), scene.name)
    found = [Moment(views, iteration) for views, iteration in selections(settings.protocol, budget)]
    wanted = settings.common_states.views
    return sorted(
        {min(found, key=lambda moment: (abs(moment.views - views), moment.views)) for views in wanted},
        key=lambda moment: moment.views,
    )


def capture_order(scene: Scene, settings: CommonStatesJob, seed: int) -> IndexArray:
    """Return all of the pool in the order of capture: the initial views of every episode, then ``order``'s."""
    initial = initial_captures(scene, settings.protocol)
    if settings.common_states.order == "farthest":
        return initial_captures(scene, settings.protocol, len(scene.pool))
    rng = np.random.default_rng(seed_of("common states", scene.name, seed))
    return np.concatenate([initial, rng.permutation(np.setdiff1d(scene.pool, initial))])


class _States:
    """The common states of one scene with one seed; their checkpoints lie in a folder while methods score."""

    def __init__(self, scene: Scene, settings: CommonStatesJob, seed: int, folder: Path, progress: Progress) -> None:
        self.scene = scene
        self.order = capture_order(scene, settings, seed)
        self.moments = moments_of(scene, settings)
        _, self.notes = capped_budget(settings.protocol, len(scene.pool), scene.name)
        self.notes += [f"{scene.name}: {note}" for note in scene.notes]
        self._settings = settings
        self._seed = seed
        self._folder = folder
        self._progress = progress
        self._photographs = Photographs(scene)

    def measure(self) -> list[CommonState]:
        """Fit the reconstruction, keep a checkpoint of each moment, and return the truth of its candidates."""
        session, found = self._session(self._build()), []
        for moment in self._fitted(session):
            start = clock(self._settings.device)
            session.representation.save(self._checkpoint(moment))
            found.append(self._measured(session, moment))
            seconds = clock(self._settings.device) - start
            self._progress(f"{self.scene.name}, {moment.views} views: truth measured in {seconds:.1f} s")
        return found

    def scored(self, settings: ScoredMethodSettings, weights: Path | None) -> ScoredMethod:
        """Return the scores of a method at every moment, or why they are not there."""
        method, start = registry.find(settings.method).method, clock(self._settings.device)
        checked = registry.create_settings(settings.method, settings.selector)
        selector: Selector | None = None
        failure = None
        own_fit = False
        notes: list[str] = []
        scores: list[list[float | None] | None] = []
        seed_global_generators("method", self.scene.name, settings.method, self._seed)
        try:
            selector = method.selector(checked, Resources(weights, self._settings.device))
            own_fit = isinstance(selector, PreparesRepresentation)
            for state in self._shown(settings, method, selector):
                with untouched(method.label, state, disposable=not own_fit):
                    chosen = select_views(method, selector, state, 1)
                scores.append(chosen.recorded_scores())
            notes = notes_of(method, selector)
        # a plug-in may raise anything, or end the process; the others' scores are worth more than its end
        except (Exception, SystemExit) as error:
            # marked, so that nobody takes it for the end of this job
            print(textwrap.indent(traceback.format_exc(), "| "), flush=True)
            self._photographs = Photographs(self.scene)  # it may have written into those that it was shown
            failure = str(error) if isinstance(error, UserError) else f"{type(error).__name__}: {error}"
        seconds = clock(self._settings.device) - start
        self._progress(f"{self.scene.name}, {method.label}: {failure or f'scored in {seconds:.1f} s'}")
        return ScoredMethod(
            method=settings.method,
            label=method.label,
            group=method.group,
            chooses=method.chooses,
            selector=checked.model_dump(mode="json"),
            weights_hash=None if weights is None else file_hash(weights),
            own_fit=own_fit,
            notes=notes,
            scores=[*scores, *[None] * (len(self.moments) - len(scores))],
            failure=failure,
        )

    def _shown(self, settings: ScoredMethodSettings, method: Method, selector: Selector) -> Iterator[State]:
        """Yield what a method may look at, at one moment after another: what it sees there in an episode.

        Each time it gets the checkpoint anew, whatever it has done to the reconstruction before. Only a method that
        changes the optimisation has one that was fitted its way, on the same views up to the same steps.
        """
        own_fit = isinstance(selector, PreparesRepresentation)
        session = self._session(preparing(self._build(), method, selector))
        protocol, together = self._settings.protocol, settings.views_together
        for number, moment in enumerate(self._fitted(session) if own_fit else self._loaded(session)):
            rng = np.random.default_rng(seed_of("common states", self.scene.name, settings.method, self._seed, number))
            yield session.state(rng, selection_number(protocol, moment.views, together), method.oracle)

    def _build(self) -> Builder:
        return builder(self.scene, self._settings.representation, self._seed, self._settings.device)

    def _session(self, build: Builder) -> Session:
        initial = self.order[: self._settings.protocol.initial_views]
        return Session(self.scene, build, initial, self._settings.device, self._photographs)

    def _fitted(self, session: Session) -> Iterator[Moment]:
        """Fit along the schedule of an episode, and yield each moment when it is reached."""
        protocol, waiting = self._settings.protocol, list(self.moments)
        for iteration in protocol.additions:
            session.fit_until(iteration)
            if len(session.captured) == waiting[0].views:
                yield waiting.pop(0)
            if not waiting:
                return
            done = len(session.captured)
            session.capture(self.order[done : done + protocol.views_per_step])
            if protocol.refit == "reinit":
                session.restart()

    def _loaded(self, session: Session) -> Iterator[Moment]:
        for moment in self.moments:
            session.capture(self.order[len(session.captured) : moment.views])
            session.representation.load(self._checkpoint(moment))
            session.iteration = moment.iteration
            yield moment

    def _checkpoint(self, moment: Moment) -> Path:
        return self._folder / f"{moment.views}.safetensors"

    def _measured(self, session: Session, moment: Moment) -> CommonState:
        state = session.state(np.random.default_rng(0), 0, oracle=True)
        psnr, ssim = true_metrics(state, ("psnr", "ssim")).tolist()
        return CommonState(
            views=moment.views,
            iteration=moment.iteration,
            primitives=session.representation.primitives,
            reconstruction=file_hash(self._checkpoint(moment)),
            candidates=list(state.names),
            psnr=psnr,
            ssim=ssim,
            gains=self._gains(session, state),
        )

    def _gains(self, session: Session, state: State) -> list[list[float | None]] | None:
        """Return the measurements of the gain, each with a random stream of its own, or None without copies."""
        truth, settings = state.truth, self._settings.common_states
        assert truth is not None  # asked for as an oracle
        representation = session.representation
        if not isinstance(representation, Copyable):
            return None
        parts = (self.scene.name, self._seed, len(session.captured))
        rows = sample(np.random.default_rng(seed_of("sample", *parts)), len(state.names), _sample_size(settings, state))
        found: list[list[float | None]] = []
        for number in range(MEASUREMENTS):
            seed = seed_of("gain", *parts, number)
            values = gains(
                representation, state.captured, truth.candidates[rows], truth.test, settings.gain_passes, seed=seed
            )
            measured = dict(zip(rows.tolist(), values.tolist(), strict=True))
            found.append([measured.get(row) for row in range(len(state.names))])
        return found


def _sample_size(settings: CommonStatesSettings, state: State) -> int:
    return len(state.names) if settings.gain_candidates is None else settings.gain_candidates
