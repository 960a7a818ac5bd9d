"""A reconstruction while views are captured: what view synthesis, the timing and the distortion data have in common."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from avs.representations.base import Renderer, Rendering, Representation
from avs.scene.cameras import Cameras, IndexArray
from avs.scene.photographs import Photographs
from avs.scene.scene import Scene
from avs.scene.views import Views
from avs.selection.choice import select_views
from avs.selection.contract import Method, PreparesRepresentation, Selection, Selector, State, Truth
from avs.selection.untouched import untouched
from avs.system.global_state import unchanged
from avs.system.provenance import clock

Builder = Callable[[IndexArray], Representation]
"""Makes an untrained representation, given the scene's indices of the captured views."""


class Session:
    """Views of one scene, captured one after another, and the reconstruction that is fitted to them.

    Attributes:
        scene: the capture.
        captured: indices of the captured views, in order of capture.
        views: the captured views.
        representation: the current reconstruction.
        iteration: optimisation steps done so far.
    """

    def __init__(
        self,
        scene: Scene,
        build: Builder,
        initial: IndexArray,
        device: str = "cpu",
        photographs: Photographs | None = None,
    ) -> None:
        """Capture the initial views and build the reconstruction.

        Args:
            scene: the capture.
            build: makes an untrained reconstruction, prepared by the method (``preparing``) if it asks for that.
            initial: indices of the views to begin with.
            device: ``cpu`` or ``cuda``, for the clock.
            photographs: those of the scene, if they are decoded already; None reads each when it is captured.

        Raises:
            UserError: an image is damaged; or what ``build`` raises.
        """
        self.scene = scene
        self.captured: list[int] = initial.tolist()
        self._photographs = photographs or Photographs(scene)
        self.views: Views = self._photographs.views(initial)
        self._build = build
        self._device = device
        self.iteration = 0
        self.representation = self._built()

    @property
    def candidates(self) -> IndexArray:
        """Indices of the pool's views that are not captured, ascending."""
        return np.setdiff1d(self.scene.pool, self.captured)

    def fit_until(self, iteration: int) -> float:
        """Optimise on the captured views up to step ``iteration``, and return the seconds it took."""
        start = clock(self._device)
        self.representation.fit(self.views, iteration - self.iteration)
        self.iteration = iteration
        return clock(self._device) - start

    def capture(self, indices: IndexArray) -> None:
        """Add the views at ``indices`` of the scene, in that order.

        Raises:
            UserError: an image is damaged.
        """
        if len(indices):
            self.views = self.views.extended(self._photographs.views(indices))
            self.captured.extend(indices.tolist())

    def restart(self) -> None:
        """Put an untrained reconstruction in the place of the current one; the count of steps goes on."""
        self.representation = self._built()

    def state(self, rng: np.random.Generator, step: int, oracle: bool = False, without: int = 0) -> State:
        """Return what a method may look at.

        Args:
            rng: generator for the method's random choices.
            step: number of the selection, from 0.
            oracle: whether the hidden photographs are shown.
            without: how many of the views captured last are left out of ``captured``; one is always shown.
        """
        candidates = self.candidates
        shown = np.arange(max(1, len(self.captured) - without))
        return State(
            representation=self.representation,
            captured=self.views[shown],  # cameras of its own: what a method does to them in place stays with it
            candidates=self.scene.cameras[candidates],
            names=tuple(self.scene.names[index] for index in candidates),
            rng=rng,
            step=step,
            truth=self.truth() if oracle else None,
        )

    def photographs(self, indices: Sequence[int]) -> Views:
        """Return the photographs at ``indices`` of the scene, captured or not: what a method does not see."""
        return self._photographs.views(np.array(indices, dtype=np.int64))

    def truth(self) -> Truth:
        """Return the hidden photographs: those of the candidates, and the test images."""
        return Truth(self._photographs.views(self.candidates), self._photographs.views(self.scene.test))

    def _built(self) -> Representation:
        return self._build(np.array(self.captured, dtype=np.int64))


def preparing(build: Builder, method: Method, selector: object) -> Builder:
    """Return ``build`` with what a method does to each reconstruction before it is fitted, if anything.

    Args:
        build: makes an untrained reconstruction.
        method: its metadata.
        selector: what ``method`` built.

    What it returns raises:
        UserError: the reconstruction lacks what the method adds to, or a setting of torch was changed for the whole
            process; it is restored.
    """
    if not isinstance(selector, PreparesRepresentation):
        return build
    prepare = selector.prepare

    def make(captured: IndexArray) -> Representation:
        representation = build(captured)
        with unchanged(method.label):
            prepare(representation)
        return representation

    return make


class Stopwatch:
    """A renderer that keeps the time which its inner one takes, so that no method needs a clock of its own.

    Attributes:
        inner: the representation; ``avs.representations.capabilities.capability`` looks there for more than rendering.
        seconds: time spent in ``render`` so far.
    """

    def __init__(self, inner: Renderer, device: str) -> None:
        """Time ``inner`` on ``device``."""
        self.inner = inner
        self.seconds = 0.0
        self._device = device

    def render(self, cameras: Cameras) -> Rendering:
        """Render ``cameras``, see ``avs.representations.base.Renderer``."""
        start = clock(self._device)
        rendering = self.inner.render(cameras)
        self.seconds += clock(self._device) - start
        return rendering


@dataclass(frozen=True)
class TimedSelection:
    """A selection and how long it took.

    Attributes:
        selection: the outcome.
        total_seconds: from the call to the choice.
        render_seconds: the part of it that rendering through ``State.representation`` took.
    """

    selection: Selection
    total_seconds: float
    render_seconds: float

    @property
    def score_seconds(self) -> float:
        """Everything but rendering."""
        return self.total_seconds - self.render_seconds


def timed_selection(method: Method, selector: Selector, state: State, k: int, device: str) -> TimedSelection:
    """Let a method choose ``k`` candidates, with the clock running; see ``avs.selection.choice.select_views``.

    Raises:
        UserError: the method changed what it was shown; see also ``select_views``.
    """
    stopwatch = Stopwatch(state.representation, device)
    with untouched(method.label, state):
        start = clock(device)
        selection = select_views(method, selector, replace(state, representation=stopwatch), k)
        seconds = clock(device) - start
    return TimedSelection(selection, seconds, stopwatch.seconds)
