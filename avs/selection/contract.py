"""The contract of a selection method.

A method is one entry of the ``METHODS`` dictionary of a module of ``avs.selectors``, or of an installed package's entry
point in the group ``avs.selectors``; nothing lists them elsewhere. The modules must not import torch at import time, so
that the workflow can read their metadata quickly.

Most methods give each candidate a score (``ScoringSelector``); the loop chooses. A method that chooses several views
together is a ``JointSelector``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from avs.representations.base import Renderer, Representation
from avs.scene.cameras import Cameras
from avs.scene.views import Views
from avs.system.errors import UserError
from avs.system.global_state import unchanged
from avs.system.models import StrictModel

ORACLE = "Oracle"
"""Row group of the methods that look at hidden photographs: upper references, which no method is ranked against."""

OWN_SCHEDULE = "Own schedule"
"""Row group of the methods whose views come at other moments than those of all others, or to a reconstruction that then
begins anew while that of all others goes on, or the other way round: no rank, for that reason."""

REPLAYED = "Replayed views"
"""Row group of the methods that capture another's views on a reconstruction which that method has not changed."""

UNRANKED = {
    OWN_SCHEDULE: "views come at other moments than in the other rows, or the reconstruction does not go on as theirs "
    "does when they come, which by itself changes the result; no rank",
    REPLAYED: "the views of another row, captured when they are there, on a reconstruction that is fitted as most are: "
    "what the choice does by itself; no rank, because choosing took that row's own reconstruction",
    ORACLE: "chosen by looking at photographs that a method cannot see; upper references without a rank",
}
"""The row groups that do not compete, each with what a table says of it."""

Direction = Literal["lowest", "highest"]
"""Which scores are captured first."""

TruthName = Literal["ssim", "psnr", "gain"]
"""What the hidden photographs say of a candidate: SSIM and PSNR of its rendering, and the gain of capturing it."""


class Settings(StrictModel):
    """Base of a method's settings: unknown keys are errors, values do not change. Subclass it to add fields."""

    @property
    def needs(self) -> tuple[str, ...] | None:
        """The capabilities that a method needs with these settings; None where they do not change ``Method.needs``."""
        return None


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
    """All that a method may look at.

    Attributes:
        representation: the current reconstruction. A 2D method may only call ``render``; for more, ask
            ``avs.representations.capabilities.capability``.
        captured: the views captured so far, in order of capture.
        candidates: cameras of the n views that can be captured, in pool order.
        names: their n image names.
        rng: generator for random choices, its state depends on the seed, method, scene and step alone.
        step: number of the selection, from 0.
        truth: the hidden photographs, for a method whose metadata say ``oracle``; None for all others.
    """

    representation: Renderer
    captured: Views
    candidates: Cameras
    names: tuple[str, ...]
    rng: np.random.Generator
    step: int
    truth: Truth | None = None


@dataclass(frozen=True)
class Selection:
    """The outcome of one selection.

    Attributes:
        indices: ``[k]`` int64 rows of ``State.candidates``, in order of preference, without repetition. The first is
            the candidate of the best score.
        scores: ``[n]`` float64, one finite score per candidate; None in a replay, which does not score.
        scored: ``[n]`` bool, for a method that scores some of the candidates only, and chooses among them: which ones.
            The scores of the others are not read. None means all of them.
    """

    indices: npt.NDArray[np.int64]
    scores: npt.NDArray[np.float64] | None
    scored: npt.NDArray[np.bool_] | None = None

    def recorded_scores(self) -> list[float | None] | None:
        """Return the scores as a record has them: None for candidates that were not scored, and without any scores."""
        if self.scores is None or self.scored is None:
            return None if self.scores is None else self.scores.tolist()
        pairs = zip(self.scores.tolist(), self.scored.tolist(), strict=True)
        return [score if scored else None for score, scored in pairs]


@runtime_checkable
class ScoringSelector(Protocol):
    """Scores every candidate by itself; the loop takes the best, ties to the lowest index."""

    def score(self, state: State) -> npt.NDArray[np.float64]:
        """Return one finite score for each of the n candidates, ``[n]``; ``Method.chooses`` tells which are taken."""
        ...


@runtime_checkable
class JointSelector(Protocol):
    """Chooses several views together, each with regard to those chosen before it."""

    def select(self, state: State, k: int) -> Selection:
        """Return the ``k`` candidates to capture next, 1 <= k <= n, and the score that each of the n has by itself.

        Ties go to the lowest index.
        """
        ...


Selector = ScoringSelector | JointSelector


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
class PredictsMaps(Protocol):
    """Capability of a selector: it predicts the quality of a rendering at each place, not only as a score."""

    def predicted_map(self, state: State, row: int) -> npt.NDArray[np.float32]:
        """Return the predicted SSIM ``[height, width]`` of the rendering of a candidate, nominally in 0..1.

        It is asked for outside of the measured time, right after the selection in ``state``, to be kept as a picture,
        and not at all where none is kept: nothing that the next selection depends on may change with it. Its shape may
        be another one than the rendering's.
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
class Batches:
    """Several views chosen together: what a method changes in the loop by its definition.

    Attributes:
        views: how many are chosen together.
        additions: optimisation steps after which a whole batch is captured at once, ascending, out of ``iterations``; a
            run of another length scales them. None: views are captured one after another when those of all methods are,
            and the next batch is chosen when all of them are captured.
        iterations: length of the published schedule, in optimisation steps.
    """

    views: int
    additions: tuple[int, ...] | None = None
    iterations: int = 30_000

    def scaled(self, iterations: int) -> tuple[int, ...] | None:
        """Return ``additions`` for an optimisation of ``iterations`` steps, rounded to whole steps."""
        if self.additions is None:
            return None
        return tuple(round(addition * iterations / self.iterations) for addition in self.additions)


@dataclass(frozen=True)
class Method:
    """Metadata of one selection method.

    Attributes:
        label: the name printed in tables.
        group: row group in the paper's Table 1: ``Geometric``, ``3D-based`` or ``2D-based``; or one of ``UNRANKED``.
        source: the publication or code that defines the method, and every deviation from it, in one or two sentences.
        chooses: whether the candidate of the ``lowest`` or of the ``highest`` score is captured.
        build: makes the selector from its settings and resources; call it by ``selector``, which checks these first.
        settings: the type of its settings.
        needs: what it uses of a representation beside ``render``, by the names of
            ``avs.representations.capabilities.CAPABILITIES``; a run whose representation lacks it leaves the method out
            and says so in its row.
        batches: how many views it chooses together, and when they are captured, if that is part of its definition.
        scorer: name of the trained scorer whose weights it needs, or None.
        pretrained: names of the published weights that it needs, entries of the manifest of ``avs.system.weights``; a
            run without them leaves the method out and says so in its row.
        fallback: name of parameters that a run can fit on its training scenes in place of absent published ones, or
            where there are none; they are passed as ``Resources.weights``.
        oracle: whether it looks at photographs that are not captured yet, through ``State.truth``.
        measures: for an oracle that chooses by a truth that scores are compared with: which one. That truth stands in
            its place where methods are ranked, because its correlation with itself says nothing.
        assesses_images: whether its selector has ``quality``, the score ``[n]`` of images ``[n, height, width, 3]`` by
            themselves, so that renderings of held-out scenes can be scored, too.
        proposed: whether the paper proposes it, so that tables and figures set it off from the others.
        scene_units: whether its scores depend on the unit of length. A scene's extent has five of those units; the map
            of an exploration is in metres, so that such a method cannot choose its paths.
        follows: identifier of the method whose views it captures, in their order, from the episode of the same scene
            and seed; ``following`` makes such a method. None for a method that chooses.
    """

    label: str
    group: str
    source: str
    chooses: Direction
    build: Callable[..., Selector]
    settings: type[Settings] = field(default=Settings)
    needs: tuple[str, ...] = ()
    batches: Batches | None = None
    scorer: str | None = None
    pretrained: tuple[str, ...] = ()
    fallback: str | None = None
    oracle: bool = False
    measures: TruthName | None = None
    assesses_images: bool = False
    proposed: bool = False
    scene_units: bool = False
    follows: str | None = None

    def selector(self, settings: Settings, resources: Resources) -> Selector:
        """Return the selector that ``build`` makes.

        Raises:
            UserError: the method needs a trained scorer and has no weights of it, or ``build`` changed a setting of
                torch for the whole process; or what it raises.
        """
        if self.scorer is not None and resources.weights is None:
            raise UserError(self.label, f"needs the weights of the scorer {self.scorer}", "pass --weights")
        with unchanged(self.label):
            return self.build(settings, resources)


def following(other: str, label: str, source: str) -> Method:
    """Return a method that captures the views of another one's episode, on a reconstruction fitted as most are.

    It parts what a method gains by its choice from what it gains by changing the reconstruction.

    Args:
        other: identifier of the method whose views are captured.
        label: the name printed in tables.
        source: what the comparison shows, in one or two sentences.
    """
    return Method(label, REPLAYED, source, "lowest", _chooses_nothing, follows=other)


def _chooses_nothing(settings: Settings, resources: Resources) -> Selector:
    raise TypeError("a method that follows another one's views chooses none: the episode gives them")
