"""Farthest-view sampling as a method: the candidate whose camera centre is farthest from all captured ones."""

from __future__ import annotations

from avs.scene.sampling import farthest_order
from avs.selection.contract import Method, Resources, Selection, Settings, State


class FarthestSelector:
    """Greedy max-min over camera centres; viewing directions play no part. A batch is chosen greedily."""

    def __init__(self, settings: Settings, resources: Resources) -> None:
        """Nothing to keep."""

    def select(self, state: State, k: int) -> Selection:
        """Return the ``k`` farthest candidates; the score is the distance to the nearest captured view."""
        indices, scores = farthest_order(state.candidates.centers, state.captured.cameras.centers, k)
        return Selection(indices, scores)


METHODS = {
    "farthest": Method(
        label="FVS",
        group="Geometric",
        source=(
            "Greedy max-min of Euclidean distances between camera centres, as FisherRF's initial views (commit "
            "b747328). The paper lists it as an oracle; it sees no image, so it is ranked as a method."
        ),
        chooses="highest",
        build=FarthestSelector,
    )
}
