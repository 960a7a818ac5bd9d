"""One episode: Algorithm 1 of the paper. Knows no method and no representation by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from avs.nvs.evaluation import Evaluator
from avs.nvs.picture_settings import PictureSettings
from avs.nvs.pictures import archive, chosen_files, final_files, final_rows, kept_pictures, predicted_maps
from avs.nvs.protocol import ProtocolSettings
from avs.nvs.record import CurvePoint, Episode, EpisodeMeta, KeptPictures, Step, StepTimes
from avs.nvs.schedule import capped_budget, initial_captures
from avs.representations.base import Representation
from avs.scene.cameras import IndexArray
from avs.scene.scene import Scene
from avs.selection.choice import notes_of
from avs.selection.contract import Method, Selector, State
from avs.selection.session import Builder, Session, preparing, timed_selection
from avs.system import provenance
from avs.system.seeds import seed_of

Progress = Callable[[str], None]
"""Takes one line about each step."""


@dataclass(frozen=True)
class Identity:
    """What an episode is called in its record; see ``avs.nvs.record.Episode`` for the fields."""

    method: str
    seed: int
    representation: dict[str, object]
    selector: dict[str, object]
    weights_hash: str | None = None
    weights_file: str | None = None
    own: tuple[str, ...] = ()


@dataclass(frozen=True)
class Plan:
    """Everything that an episode is made of.

    Attributes:
        scene: the capture.
        protocol: the settings of the loop.
        identity: names for the record.
        method: the method's metadata.
        selector: what the method built.
        build: makes the representation.
        evaluate: computes the test metrics.
        progress: receives one line about each step.
        device: ``cpu`` or ``cuda``, for the clock.
        pictures: which pictures to keep, or None for none.
    """

    scene: Scene
    protocol: ProtocolSettings
    identity: Identity
    method: Method
    selector: Selector
    build: Builder
    evaluate: Evaluator
    progress: Progress
    device: str = "cpu"
    pictures: PictureSettings | None = None


class Outcome(NamedTuple):
    """What an episode leaves.

    Attributes:
        record: what is the same whenever it is run.
        meta: what differs from run to run.
        representation: the final reconstruction.
        pictures: the archive of kept pictures; an empty one where none are kept.
    """

    record: Episode
    meta: EpisodeMeta
    representation: Representation
    pictures: bytes


def run(plan: Plan) -> Outcome:
    """Run one episode and return its two records, the final reconstruction and the pictures that are kept.

    The initial views are chosen by farthest-view sampling. At each iteration of ``protocol.additions`` the test metrics
    are measured and the method's views are captured, until the budget is reached; then the optimisation goes on to its
    end. Views that were chosen together wait for their turn: how many are captured at an iteration does not depend on
    how many are chosen at once.

    Raises:
        UserError: the pool is too small, an image is damaged, or the method asks for a capability that is not there.
    """
    started, start = provenance.now(), provenance.clock(plan.device)
    loop = _Loop(plan)
    loop.run()
    total = provenance.clock(plan.device) - start
    plan.progress(f"end, {len(loop.session.captured)} views, PSNR {loop.psnr:.2f} dB, {total:.0f} s in all")
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
    pictures = archive(loop.pictures)
    return Outcome(loop.record(pictures), meta, loop.session.representation, pictures)


@dataclass
class _Loop:
    """The state of one episode while it runs."""

    plan: Plan
    psnr: float = float("nan")
    steps: list[Step] = field(default_factory=list)
    times: list[StepTimes] = field(default_factory=list)
    curve: list[CurvePoint] = field(default_factory=list)
    waiting: list[int] = field(default_factory=list)
    pictures: dict[str, bytes] = field(default_factory=dict)
    fit_seconds: float = 0.0

    def __post_init__(self) -> None:
        plan = self.plan
        self.budget, self.notes = capped_budget(plan.protocol, len(plan.scene.pool), plan.scene.name)
        self.notes += [f"{plan.scene.name}: {note}" for note in plan.scene.notes]
        self.notes += notes_of(plan.method, plan.selector)
        scheduled = plan.identity.representation.get("iterations", plan.protocol.iterations)
        if scheduled != plan.protocol.iterations:
            end = f"the optimisation ends at iteration {plan.protocol.iterations}"
            self.notes.append(f"the schedule of the learning rates is for {scheduled} iterations, and {end}")
        initial = initial_captures(plan.scene, plan.protocol)
        build = preparing(plan.build, plan.method, plan.selector)
        self.session = Session(plan.scene, build, initial, plan.device)

    def run(self) -> None:
        """Alternate between fitting and selecting, then fit to the end."""
        protocol = self.plan.protocol
        for iteration in protocol.additions:
            if len(self.session.captured) >= self.budget:
                break
            self.fit_seconds += self.session.fit_until(iteration)
            self.measure()
            if not self.waiting:
                self.select()
            self.capture()
            if protocol.refit == "reinit":
                self.session.restart()
        self.session.fit_until(protocol.iterations)
        self.measure()
        if self.plan.pictures is not None:
            cameras = self.plan.scene.cameras[self.plan.scene.test]
            self.pictures |= final_files(self.session.representation, cameras, self.plan.pictures)
        if self.plan.evaluate.empty:
            told = "every rendering of the test cameras is of one colour, so that its metrics are those of nothing"
            self.notes.append(f"{self.plan.scene.name}: {told}")

    def measure(self) -> None:
        """Append the test metrics to the curve."""
        session = self.session
        images = self.plan.evaluate(session.representation)
        self.psnr = float(np.mean([image.psnr for image in images]))
        self.curve.append(
            CurvePoint(
                iteration=session.iteration,
                views=len(session.captured),
                primitives=session.representation.primitives,
                images=images,
            )
        )

    def select(self) -> None:
        """Let the method choose; its choice waits to be captured."""
        plan, session, step = self.plan, self.session, len(self.steps)
        k = min(plan.protocol.views_together, self.budget - len(session.captured))
        state = self.state(step)
        timed = timed_selection(plan.method, plan.selector, state, k, plan.device)
        self.steps.append(
            Step(
                step=step,
                iteration=session.iteration,
                primitives=session.representation.primitives,
                candidates=list(state.names),
                scores=timed.selection.recorded_scores(),
                chosen=[state.names[row] for row in timed.selection.indices],
                captured=[],
            )
        )
        self.times.append(
            StepTimes(
                render_seconds=timed.render_seconds,
                score_seconds=timed.score_seconds,
                total_seconds=timed.total_seconds,
                fit_seconds=self.fit_seconds,
                peak_memory_bytes=provenance.peak_memory(plan.device),
            )
        )
        self.fit_seconds = 0.0
        self.waiting = session.candidates[timed.selection.indices].tolist()
        if plan.pictures is not None and plan.pictures.choices:
            maps = predicted_maps(plan.method, plan.selector, state, timed.selection.indices.tolist())
            photographs = session.photographs(self.waiting)
            self.pictures |= chosen_files(session.representation, photographs, maps, step, plan.pictures)
        self.report(timed.total_seconds)

    def capture(self) -> None:
        """Capture the views whose turn it is."""
        count = self.plan.protocol.views_per_step
        now, self.waiting = self.waiting[:count], self.waiting[count:]
        self.session.capture(np.array(now, dtype=np.int64))
        self.steps[-1].captured.extend([self.session.iteration] * len(now))

    def state(self, step: int) -> State:
        """Return what the method may look at."""
        scene, identity = self.plan.scene, self.plan.identity
        rng = np.random.default_rng(seed_of("selection", scene.name, identity.method, identity.seed, step))
        return self.session.state(rng, step, self.plan.method.oracle)

    def report(self, seconds: float) -> None:
        """Tell one line about the selection just made."""
        protocol = self.plan.protocol
        steps = -(-(self.budget - protocol.initial_views) // protocol.views_together)
        step, chosen = len(self.steps), ", ".join(self.steps[-1].chosen)
        self.plan.progress(f"step {step} of {steps}, view {chosen}, PSNR {self.psnr:.2f} dB, {seconds:.2f} s")

    def record(self, pictures: bytes) -> Episode:
        """Return the deterministic record of the finished episode, which kept these pictures."""
        scene, identity, method = self.plan.scene, self.plan.identity, self.plan.method
        names = list(self.session.views.names)
        initial = self.plan.protocol.initial_views
        return Episode(
            scene=scene.name,
            dataset=scene.dataset,
            scene_hash=scene.content_hash,
            image_size=_largest(scene.cameras.sizes),
            method=identity.method,
            label=method.label,
            group=method.group,
            chooses=method.chooses,
            seed=identity.seed,
            protocol=self.plan.protocol.model_dump(mode="json"),
            representation=identity.representation,
            selector=identity.selector,
            weights_hash=identity.weights_hash,
            weights_file=identity.weights_file,
            own=list(identity.own),
            initial=names[:initial],
            selected=names[initial:],
            budget=self.budget,
            notes=self.notes,
            absent=self.plan.evaluate.absent,
            steps=self.steps,
            curve=self.curve,
            pictures=self.kept(pictures),
        )

    def kept(self, pictures: bytes) -> KeptPictures | None:
        """Return what the record says of the archive of pictures."""
        scene, settings = self.plan.scene, self.plan.pictures
        if settings is None:
            return None
        return kept_pictures(pictures, [scene.names[scene.test[row]] for row in final_rows(len(scene.test), settings)])


def _largest(sizes: IndexArray) -> tuple[int, int]:
    """Return the width and the height of the image with the most pixels, of ``[n, 2]``."""
    width, height = sizes[sizes.prod(axis=1).argmax()].tolist()
    return width, height
