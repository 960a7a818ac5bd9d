"""Random selection: the baseline that any method has to beat."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from pydantic import Field

from avs.selection.contract import Method, Resources, Settings, State


class RandomSettings(Settings):
    """Settings of random selection."""

    reshuffle: bool = Field(
        default=False,
        description="draw the same random numbers at every step, as FisherRF's code does by seeding again at each call",
    )


class RandomSelector:
    """Chooses uniformly among the candidates, without replacement; the score is the random number itself."""

    def __init__(self, settings: RandomSettings, resources: Resources) -> None:
        """Keep the settings; no resources are needed."""
        self._reshuffle = settings.reshuffle
        self._state: dict[str, object] | None = None

    def score(self, state: State) -> npt.NDArray[np.float64]:
        """Return a random number in 0..1 for each candidate, ``[n]``."""
        generator = state.rng
        if self._reshuffle:
            self._state = self._state or dict(generator.bit_generator.state)
            generator = np.random.default_rng()
            generator.bit_generator.state = self._state
        return generator.random(len(state.candidates))


METHODS = {
    "random": Method(
        label="Random",
        group="2D-based",
        source=(
            "Uniform choice. FisherRF's RandSelector (commit b747328) seeds its generator again at each call, so its "
            "draws repeat; here they do not, unless reshuffle is set."
        ),
        chooses="lowest",
        build=RandomSelector,
        settings=RandomSettings,
    )
}
