"""Selection by diagonal Fisher information: what FisherRF and POp-GS share."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field, NonNegativeInt, PositiveInt

from avs.representations.base import Renderer
from avs.representations.capabilities import FisherInformation, HasFisherDiagonal, HasFisherProbes, capability
from avs.scene.cameras import Cameras
from avs.selection.contract import Selection, Settings, State

Parameter = Literal["means", "f_dc", "f_rest", "scales", "opacities", "quats"]

Gain = Callable[[npt.NDArray[np.float32], npt.NDArray[np.float64], float], float]
"""What a candidate adds: a function of its information, that of the captured views (both ``[m, parameters]``), lambda.

It must not grow with the captured views' information, which the greedy choice relies on.
"""


class InformationSettings(Settings):
    """Settings of the methods on Fisher information."""

    chain: Literal["once", "squared"] = Field(
        default="once",
        description="how an activation's derivative enters the square: once, as in FisherRF's code, or squared",
    )
    regularisation: float = Field(
        default=1e-6, gt=0, description="lambda, added to the information of the captured views before dividing by it"
    )
    parameters: tuple[Parameter, ...] = Field(
        default=("means", "f_dc", "f_rest", "scales", "opacities"),
        min_length=1,
        description="parameters that count: positions, colours and their view-dependent part, scales, opacities, "
        "rotations",
    )
    estimator: Literal["exact", "probes"] = Field(
        default="exact",
        description="exact: sums over pixels, on the CPU; probes: random sign images, on the reconstruction's device",
    )
    probes: PositiveInt = Field(default=4, description="sign images per candidate")
    captured_probes: PositiveInt = Field(
        default=16, description="sign images per captured view: noise in a denominator is a bias, so more of them"
    )
    kept_mebibytes: NonNegativeInt = Field(
        default=1024,
        description="candidates' information kept for the later rounds of a batch choice; what does not fit is "
        "computed again when needed",
    )

    @property
    def needs(self) -> tuple[str, ...]:
        """The capability that the estimator uses."""
        return ("fisher_diagonal",) if self.estimator == "exact" else ("fisher_probes",)


class InformationSelector:
    """Largest gain against the captured views; of several candidates each against those before it, too.

    The candidates pass by one after another: memory holds the captured views' sum (8 bytes for each parameter), one
    candidate and, for k > 1, ``kept_mebibytes`` of them.
    """

    def __init__(self, method: str, gain: Gain, settings: InformationSettings) -> None:
        """Select by ``gain``; ``method`` is named in errors."""
        self._method = method
        self._gain = gain
        self._settings = settings

    def select(self, state: State, k: int) -> Selection:
        """Return ``k`` candidates, greedily; the scores are those of the first round.

        Raises:
            UserError: the representation has no Fisher information.
        """
        settings = self._settings
        seeds = state.rng.integers(2**32, size=(2, max(len(state.captured), len(state.candidates)))).tolist()
        views = self._information(state.representation, state.captured.cameras, settings.captured_probes, seeds[0])
        candidates = Candidates(
            lambda rows: self._information(
                state.representation, state.candidates[rows], settings.probes, [seeds[1][row] for row in rows]
            ),
            settings.kept_mebibytes * 2**20 if k > 1 else 0,
        )
        indices, scores = choose_greedily(
            candidates, len(state.candidates), total(views), k, self._gain, settings.regularisation
        )
        return Selection(indices, scores)

    def _information(
        self, representation: Renderer, cameras: Cameras, probes: int, seeds: Sequence[int]
    ) -> Iterator[FisherInformation]:
        settings = self._settings
        if settings.estimator == "exact":
            exact = capability(representation, HasFisherDiagonal, self._method)
            return exact.fisher_diagonal(cameras, settings.chain, settings.parameters)
        estimating = capability(representation, HasFisherProbes, self._method)
        return estimating.fisher_probes(cameras, settings.chain, settings.parameters, probes, seeds[: len(cameras)])


class Candidates:
    """The information of candidates by row; some of it is kept, the rest computed whenever it is asked for."""

    def __init__(self, compute: Callable[[Sequence[int]], Iterator[FisherInformation]], room: int) -> None:
        """Keep up to ``room`` bytes of what ``compute`` gives for rows."""
        self._compute = compute
        self._room = room
        self._kept: dict[int, FisherInformation] = {}

    def first_round(self, count: int) -> Iterator[FisherInformation]:
        """Yield the information of candidates 0 to ``count - 1``."""
        for row, information in enumerate(self._compute(range(count))):
            size = information.values.nbytes + information.rows.nbytes
            if size <= self._room:
                self._room -= size
                self._kept[row] = information
            yield information

    def __getitem__(self, row: int) -> FisherInformation:
        """Return the information of one candidate."""
        return self._kept[row] if row in self._kept else next(self._compute([row]))


def total(information: Iterator[FisherInformation]) -> npt.NDArray[np.float64]:
    """Return the sum over one or more views, ``[primitives, parameters]``."""
    first = next(information)
    summed = np.zeros((first.primitives, first.values.shape[1]))
    summed[first.rows] = first.values
    for view in information:
        summed[view.rows] += view.values
    return summed


def choose_greedily(
    candidates: Candidates, count: int, captured: npt.NDArray[np.float64], k: int, gain: Gain, regularisation: float
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Return ``k`` candidates of the largest gain, each added to ``captured`` before the next, and the first scores.

    A gain does not grow when information is added (and neither do its roundings, as its terms are always summed in the
    same order). So a score from an earlier round bounds the present one, and only candidates whose bound is the largest
    are scored again (Minoux, 1978): the same choice as scoring all of them in every round. Ties go to the lowest index.
    """

    def score(information: FisherInformation) -> float:
        return gain(information.values, captured[information.rows], regularisation)

    scores = np.array([score(information) for information in candidates.first_round(count)])
    chosen, bounds = [int(np.argmax(scores))], scores.copy()
    while len(chosen) < k:
        last = candidates[chosen[-1]]
        captured[last.rows] += last.values
        bounds[chosen[-1]] = -np.inf
        scored_again = set[int]()
        while (best := int(np.argmax(bounds))) not in scored_again:
            bounds[best] = score(candidates[best])
            scored_again.add(best)
        chosen.append(best)
    return np.array(chosen, dtype=np.int64), scores
