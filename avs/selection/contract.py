"""The contract of a selection method.

A method is one entry of the ``METHODS`` dictionary of a module in this folder, or of an installed package's entry point
in the group ``avs.selectors``; nothing lists them elsewhere. The modules must not import torch at import time, so that
the workflow can read their metadata quickly.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from avs.representations.base import Renderer, Rendering, Representation
from avs.scene.cameras import Cameras
from avs.scene.views import Views
from avs.system.errors import UserError
from avs.system.models import StrictModel

ORACLE = "Oracle"
"""Row group of the methods that look at hidden photographs: upper references, which no method is ranked against."""


class Settings(StrictModel):
    """Base of a method's settings: unknown keys are errors, values do not change. Subclass it to add fields."""


@dataclass(frozen=True)
class Truth:
    """What is hidden from a method, and shown to an oracle only.

    Attributes:
        candidates: the photographs that the candidates would give, in the candidates' order.
        test: the test photographs.
    """

    candidates: Views
    test: Views


@dataclass(frozen=True)
class State:
    """All that a selector may look at.

    Attributes:
        representation: the current reconstruction. A 2D method may only call ``render``; for more, ask
            ``avs.representations.capabilities.capability``.
        captured: the views captured so far, in order of capture.
        candidates: cameras of the views that can be captured, in pool order.
        rng: generator for random choices, its state depends on the seed, method, scene and step alone.
        step: number of the selection, from 0.
        truth: the hidden photographs, for a method whose metadata say ``oracle``; None for all others.
    """

    representation: Renderer
    captured: Views
    candidates: Cameras
    rng: np.random.Generator
    step: int
    truth: Truth | None = None


@dataclass(frozen=True)
class Selection:
    """The outcome of one selection.

    Attributes:
        indices: ``[k]`` int64 rows of ``State.candidates``, in order of preference, without repetition.
        scores: ``[n]`` float64, one finite score per candidate; None in a replay, which does not score.
        render_seconds: time spent in rendering candidates.
        scored: ``[n]`` bool, for a method that scores some of the candidates only, and chooses among them: which ones.
            The scores of the others are not read. None means all of them.
    """

    indices: npt.NDArray[np.int64]
    scores: npt.NDArray[np.float64] | None
    render_seconds: float = 0.0
    scored: npt.NDArray[np.bool_] | None = None


class Selector(Protocol):
    """Chooses k of the candidates."""

    def select(self, state: State, k: int) -> Selection:
        """Return the ``k`` candidates to capture next, 1 <= k <= n, and the score of each of the n candidates.

        Ties go to the lowest index.
        """
        ...


@runtime_checkable
class PreparesRepresentation(Protocol):
    """Capability of a selector: it changes how the reconstruction is optimised, as ActiveNeRF does."""

    def prepare(self, representation: Representation) -> None:
        """Prepare a reconstruction that has just been built and not been fitted yet.

        Add parameters or a loss term through ``avs.representations.capabilities.capability``.

        Raises:
            UserError: the representation lacks the capability.
        """
        ...


@runtime_checkable
class HasNotes(Protocol):
    """Capability of a selector: it tells what a reader of its results should know; the record and the table repeat it.

    Attributes:
        notes: sentences without a full stop, the same in every episode of a run.
    """

    notes: tuple[str, ...]


@dataclass(frozen=True)
class Resources:
    """What a selector may need from outside, apart from its settings.

    Attributes:
        weights: checkpoint of the trained scorer that ``Method.scorer`` names, the file of the weights that
            ``Method.pretrained`` names or of its fallback; or None.
        device: ``cpu`` or ``cuda``.
    """

    weights: Path | None = None
    device: str = "cpu"


@dataclass(frozen=True)
class Method:
    """Metadata of one selection method.

    Attributes:
        label: the name printed in tables.
        group: row group in the paper's Table 1: ``Geometric``, ``3D-based`` or ``2D-based``; or ``ORACLE``.
        source: the publication or code that defines the method, and every deviation from it, in one or two sentences.
        higher_is_worse: whether the candidate with the largest score is chosen (True) or with the smallest (False).
        build: makes the selector from its settings and resources; call it by ``selector``, which checks these first.
        settings: the type of its settings.
        scorer: name of the trained scorer whose weights it needs, or None.
        pretrained: names of the published weights that it needs, entries of the manifest of ``avs.system.weights``; a
            run without them leaves the method out and says so in its row.
        fallback: name of parameters that a run can fit on its training scenes in place of absent published ones; they
            are passed as ``Resources.weights``.
        oracle: whether it looks at photographs that are not captured yet, through ``State.truth``.
        proposed: whether the paper proposes it, so that tables and figures set it off from the others.
    """

    label: str
    group: str
    source: str
    higher_is_worse: bool
    build: Callable[..., Selector]
    settings: type[Settings] = field(default=Settings)
    scorer: str | None = None
    pretrained: tuple[str, ...] = ()
    fallback: str | None = None
    oracle: bool = False
    proposed: bool = False

    def selector(self, settings: Settings, resources: Resources) -> Selector:
        """Return the selector that ``build`` makes.

        Raises:
            UserError: the method needs a trained scorer and has no weights of it; or what ``build`` raises.
        """
        if self.scorer is not None and resources.weights is None:
            raise UserError(self.label, f"needs the weights of the scorer {self.scorer}", "pass --weights")
        return self.build(settings, resources)


def render_in_batches(
    renderer: Renderer, cameras: Cameras, batch: int
) -> Iterator[tuple[npt.NDArray[np.int64], Rendering, float]]:
    """Render all ``cameras``, at most ``batch`` of one image size at once.

    Yields:
        The rows of the cameras, their renderings, and the seconds it took.
    """
    for _, indices in cameras.by_size():
        for rows in np.split(indices, range(batch, len(indices), batch)):
            start = time.perf_counter()
            rendering = renderer.render(cameras[rows])
            yield rows, rendering, time.perf_counter() - start


def render_candidates(
    state: State, batch: int
) -> Iterator[tuple[npt.NDArray[np.int64], npt.NDArray[np.float32], float]]:
    """Render all candidates, at most ``batch`` of one image size at once.

    Yields:
        The rows of the candidates, their renderings ``[rows, height, width, 3]`` in 0..1, and the seconds it took.
    """
    for rows, rendering, seconds in render_in_batches(state.representation, state.candidates, batch):
        yield rows, rendering.rgb, seconds


def choose(scores: npt.NDArray[np.float64], k: int, higher_is_worse: bool) -> npt.NDArray[np.int64]:
    """Return the indices of the ``k`` worst scores, worst first; ties go to the lowest index.

    Raises:
        ValueError: a score is not finite, or ``k`` is not in 1..n.
    """
    scores = np.asarray(scores, dtype=np.float64)
    if not np.isfinite(scores).all():
        raise ValueError(f"{np.count_nonzero(~np.isfinite(scores))} of {len(scores)} scores are not finite")
    if not 1 <= k <= len(scores):
        raise ValueError(f"cannot choose {k} of {len(scores)} candidates")
    return np.argsort(-scores if higher_is_worse else scores, kind="stable")[:k]


def check_selection(selection: Selection, candidates: int, k: int, method: str) -> None:
    """Refuse a selection that breaks the contract; a plug-in's author needs to know at once.

    Args:
        selection: what a selector returned.
        candidates: how many it could choose from.
        k: how many it had to choose.
        method: its name, for the message.

    Raises:
        ValueError: wrong number of indices or scores, an index out of range or repeated, a score not finite, or a
            candidate chosen that was not scored.
    """
    indices = selection.indices
    if len(indices) != k or len(set(indices.tolist())) != k or not ((indices >= 0) & (indices < candidates)).all():
        raise ValueError(f"{method} returned indices {indices}, expected {k} different ones of {candidates}")
    if selection.scores is None:
        return
    scored = np.ones(candidates, dtype=bool) if selection.scored is None else selection.scored
    shapes = {selection.scores.shape, scored.shape}
    if shapes != {(candidates,)} or not np.isfinite(selection.scores[scored]).all():
        raise ValueError(f"{method} returned scores that are not {candidates} finite numbers")
    if not scored[indices].all():
        raise ValueError(f"{method} chose a candidate that it did not score")
