"""One episode: Algorithm 1 of the paper. Knows no method and no representation by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from avs.nvs.evaluation import Evaluator
from avs.nvs.protocol import ProtocolSettings
from avs.nvs.record import CurvePoint, Episode, EpisodeMeta, Step, StepTimes, StepTruth
from avs.nvs.recorded_truth import is_measured, measure_truth
from avs.representations.base import Representation
from avs.scene.cameras import IndexArray
from avs.scene.photographs import Photographs
from avs.scene.sampling import initial_views
from avs.scene.scene import Scene
from avs.scene.views import Views
from avs.selection.contract import HasNotes, PreparesRepresentation, Selection, Selector, State, Truth, check_selection
from avs.system import provenance
from avs.system.errors import UserError
from avs.system.seeds import seed_of

Builder = Callable[[IndexArray], Representation]
"""Makes an untrained representation, given the indices of the captured views."""

Progress = Callable[[str], None]
"""Takes one line about each step."""


@dataclass(frozen=True)
class Identity:
    """What an episode is called in its record; see ``avs.nvs.record.Episode`` for the fields."""

    method: str
    label: str
    group: str
    higher_is_worse: bool
    seed: int
    representation: dict[str, object]
    selector: dict[str, object]
    weights_hash: str | None = None
    weights_file: str | None = None


@dataclass(frozen=True)
class Plan:
    """Everything that an episode is made of.

    Attributes:
        scene: the capture.
        protocol: the settings of the loop.
        identity: names for the record.
        selector: the method.
        build: makes the representation.
        evaluate: computes the test metrics.
        progress: is told one line about each step.
        device: ``cpu`` or ``cuda``, for the clock.
        oracle: whether the method may look at photographs that are not captured yet.
    """

    scene: Scene
    protocol: ProtocolSettings
    identity: Identity
    selector: Selector
    build: Builder
    evaluate: Evaluator
    progress: Progress
    device: str = "cpu"
    oracle: bool = False


def capped_budget(protocol: ProtocolSettings, pool: int, scene: str) -> tuple[int, list[str]]:
    """Return the number of views at the end, and a note if the pool is too small for the configured budget.

    Args:
        protocol: the settings of the loop.
        pool: number of images in the pool.
        scene: the name of the scene, for the note.

    Raises:
        UserError: the pool has fewer images than the initial views and one candidate.
    """
    if pool <= protocol.initial_views:
        fault = f"its pool of {pool} images leaves no candidate after {protocol.initial_views} initial views"
        raise UserError(f"scene {scene}", fault, "add images, or lower protocol.initial_views")
    allowed = max(int(pool * protocol.pool_share), protocol.initial_views + 1)
    if allowed >= protocol.budget:
        return protocol.budget, []
    return allowed, [f"{scene}: budget {allowed} instead of {protocol.budget}, because its pool has {pool} views"]


def run(plan: Plan) -> tuple[Episode, EpisodeMeta, Representation]:
    """Run one episode and return its two records and the final reconstruction.

    The initial views are chosen by farthest-view sampling. At each iteration of ``protocol.additions`` the test metrics
    are measured and the selector adds views, until the budget is reached; then the optimisation goes on to its end.

    Raises:
        UserError: the pool is too small, an image is damaged, or the method asks for a capability that is not there.
    """
    started, start = provenance.now(), provenance.clock(plan.device)
    loop = _Loop(plan)
    loop.run()
    total = provenance.clock(plan.device) - start
    plan.progress(f"end, {len(loop.captured)} views, PSNR {loop.psnr:.2f} dB, {total:.0f} s in all")
    meta = EpisodeMeta(
        steps=loop.times,
        total_seconds=total,
        peak_memory_bytes=provenance.peak_memory(plan.device),
        device=plan.device,
        machine=provenance.machine(plan.device),
        packages=provenance.packages(),
        revision=provenance.revision(),
        started=started,
        finished=provenance.now(),
    )
    return loop.record(), meta, loop.representation


@dataclass
class _Loop:
    """The state of one episode while it runs."""

    plan: Plan
    iteration: int = 0
    psnr: float = float("nan")
    steps: list[Step] = field(default_factory=list)
    times: list[StepTimes] = field(default_factory=list)
    curve: list[CurvePoint] = field(default_factory=list)

    def __post_init__(self) -> None:
        scene, protocol = self.plan.scene, self.plan.protocol
        pool = scene.pool
        self.budget, self.notes = capped_budget(protocol, len(pool), scene.name)
        if isinstance(self.plan.selector, HasNotes):
            self.notes += self.plan.selector.notes
        initial = pool[initial_views(scene.cameras[pool].centers, protocol.initial_views, protocol.initial_start)]
        self.captured: list[int] = initial.tolist()
        self.photographs = Photographs(scene)
        self.views: Views = self.photographs.views(initial)
        self.representation = self.build()

    def build(self) -> Representation:
        """Return an untrained reconstruction, prepared by the method if it asks for that."""
        representation = self.plan.build(np.array(self.captured, dtype=np.int64))
        if isinstance(self.plan.selector, PreparesRepresentation):
            self.plan.selector.prepare(representation)
        return representation

    def run(self) -> None:
        """Alternate between fitting and selecting, then fit to the end."""
        protocol = self.plan.protocol
        for step, iteration in enumerate(protocol.additions):
            if len(self.captured) >= self.budget:
                break
            fit_seconds = self.fit_until(iteration)
            self.measure()
            self.select(step, fit_seconds)
            if protocol.refit == "reinit":
                self.representation = self.build()
        self.fit_until(protocol.iterations)
        self.measure()

    def fit_until(self, iteration: int) -> float:
        """Optimise up to ``iteration`` and return the seconds it took."""
        start = provenance.clock(self.plan.device)
        self.representation.fit(self.views, iteration - self.iteration)
        self.iteration = iteration
        return provenance.clock(self.plan.device) - start

    def measure(self) -> None:
        """Append the test metrics to the curve."""
        images = self.plan.evaluate(self.representation)
        self.psnr = float(np.mean([image.psnr for image in images]))
        self.curve.append(
            CurvePoint(
                iteration=self.iteration,
                views=len(self.captured),
                primitives=self.representation.primitives,
                images=images,
            )
        )

    def select(self, step: int, fit_seconds: float) -> None:
        """Let the method choose, and capture its choice."""
        device = self.plan.device
        candidates = np.setdiff1d(self.plan.scene.pool, self.captured)
        k = min(self.plan.protocol.views_per_step, self.budget - len(self.captured))
        state = self.state(step, candidates)
        start = provenance.clock(device)
        selection = self.plan.selector.select(state, k)
        seconds = provenance.clock(device) - start
        check_selection(selection, len(candidates), k, self.plan.identity.method)
        peak_memory = provenance.peak_memory(device)
        start = provenance.clock(device)
        measured = self.measure_truth(state, candidates)
        truth_seconds = provenance.clock(device) - start
        chosen = candidates[selection.indices]
        self.steps.append(
            Step(
                step=step,
                iteration=self.iteration,
                primitives=self.representation.primitives,
                candidates=self.names(candidates),
                scores=_recorded_scores(selection),
                chosen=self.names(chosen),
                truth=measured,
            )
        )
        self.times.append(
            StepTimes(
                render_seconds=selection.render_seconds,
                score_seconds=seconds - selection.render_seconds,
                total_seconds=seconds,
                fit_seconds=fit_seconds,
                truth_seconds=truth_seconds,
                peak_memory_bytes=peak_memory,
            )
        )
        self.views = self.views.extended(self.photographs.views(chosen))
        self.captured.extend(chosen.tolist())
        self.report(step, seconds)

    def state(self, step: int, candidates: IndexArray) -> State:
        """Return what the method may see."""
        scene, identity = self.plan.scene, self.plan.identity
        rng = np.random.default_rng(seed_of("selection", scene.name, identity.method, identity.seed, step))
        truth = self.hidden(candidates) if self.plan.oracle else None
        return State(self.representation, self.views, scene.cameras[candidates], rng, step, truth)

    def hidden(self, candidates: IndexArray) -> Truth:
        """Return what an oracle may see."""
        return Truth(self.photographs.views(candidates), self.photographs.views(self.plan.scene.test))

    def measure_truth(self, state: State, candidates: IndexArray) -> StepTruth | None:
        """Measure what the protocol asks for; the sample does not depend on the method, so that a replay repeats it."""
        settings, scene, seed = self.plan.protocol.truth, self.plan.scene, self.plan.identity.seed
        if not is_measured(settings, state.step):
            return None
        rng = np.random.default_rng(seed_of("truth", scene.name, seed, state.step))
        return measure_truth(replace(state, truth=self.hidden(candidates)), settings, rng)

    def report(self, step: int, seconds: float) -> None:
        """Tell one line about the selection just made."""
        protocol = self.plan.protocol
        steps = -(-(self.budget - protocol.initial_views) // protocol.views_per_step)
        chosen = ", ".join(self.steps[-1].chosen)
        self.plan.progress(f"step {step + 1} of {steps}, view {chosen}, PSNR {self.psnr:.2f} dB, {seconds:.2f} s")

    def names(self, indices: IndexArray) -> list[str]:
        """Return the image names at ``indices``."""
        return [self.plan.scene.names[index] for index in indices]

    def record(self) -> Episode:
        """Return the deterministic record of the finished episode."""
        scene, identity = self.plan.scene, self.plan.identity
        names = self.names(np.array(self.captured, dtype=np.int64))
        initial = self.plan.protocol.initial_views
        return Episode(
            scene=scene.name,
            dataset=scene.dataset,
            scene_hash=scene.content_hash,
            method=identity.method,
            label=identity.label,
            group=identity.group,
            higher_is_worse=identity.higher_is_worse,
            seed=identity.seed,
            protocol=self.plan.protocol.model_dump(mode="json"),
            representation=identity.representation,
            selector=identity.selector,
            weights_hash=identity.weights_hash,
            weights_file=identity.weights_file,
            initial=names[:initial],
            selected=names[initial:],
            budget=self.budget,
            notes=self.notes,
            absent=self.plan.evaluate.absent,
            steps=self.steps,
            curve=self.curve,
        )


def _recorded_scores(selection: Selection) -> list[float | None] | None:
    """Return the scores, None for candidates that were not scored."""
    if selection.scores is None or selection.scored is None:
        return None if selection.scores is None else selection.scores.tolist()
    pairs = zip(selection.scores.tolist(), selection.scored.tolist(), strict=True)
    return [score if scored else None for score, scored in pairs]
