"""Random selection: the baseline that any method has to beat."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from avs.selection.contract import Method, Resources, Selection, Settings, State, choose


class RandomSettings(Settings):
    """Settings of random selection."""

    reshuffle: bool = Field(
        default=False,
        description="draw the same random numbers at every step, as FisherRF's code does by seeding anew at each call",
    )


class RandomSelector:
    """Chooses uniformly among the candidates, without replacement; the score is the random number itself."""

    def __init__(self, settings: RandomSettings, resources: Resources) -> None:
        """Keep the settings; no resources are needed."""
        self._reshuffle = settings.reshuffle
        self._state: dict[str, object] | None = None

    def select(self, state: State, k: int) -> Selection:
        """Return the ``k`` candidates of the smallest random numbers."""
        generator = state.rng
        if self._reshuffle:
            self._state = self._state or dict(generator.bit_generator.state)
            generator = np.random.default_rng()
            generator.bit_generator.state = self._state
        scores = generator.random(len(state.candidates))
        return Selection(choose(scores, k, higher_is_worse=False), scores)


METHODS = {
    "random": Method(
        label="Random",
        group="2D-based",
        source=(
            "Uniform choice. FisherRF's RandSelector (commit b747328) seeds its generator anew at each call, so its "
            "draws repeat; here they do not, unless reshuffle is set."
        ),
        higher_is_worse=False,
        build=RandomSelector,
        settings=RandomSettings,
    )
}
