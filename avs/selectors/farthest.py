"""Farthest-view sampling: the candidate whose camera centre is farthest from all captured ones."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.cameras import FloatArray
from avs.selectors.base import Method, Resources, Selection, Settings, State


def farthest_order(
    candidates: FloatArray, captured: FloatArray, k: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Greedy max-min sampling by Euclidean distance.

    Args:
        candidates: ``[n, 3]`` points to choose from.
        captured: ``[m, 3]`` points already chosen, m >= 1.
        k: how many to choose, 1 <= k <= n.

    Returns:
        The ``[k]`` chosen rows in order, ties to the lowest index; and for each candidate the distance to the nearest
        captured point before the first choice, ``[n]``, in scene units.
    """
    nearest = np.full(len(candidates), np.inf)
    for point in captured:
        np.minimum(nearest, np.linalg.norm(candidates - point, axis=1), out=nearest)
    scores = nearest.copy()
    chosen: list[int] = []
    for _ in range(k):
        best = int(np.argmax(nearest))
        chosen.append(best)
        np.minimum(nearest, np.linalg.norm(candidates - candidates[best], axis=1), out=nearest)
        nearest[chosen] = -np.inf
    return np.array(chosen, dtype=np.int64), scores


def initial_views(centers: FloatArray, k: int, start: int = 0) -> npt.NDArray[np.int64]:
    """Return ``k`` of the rows of ``centers`` ``[n, 3]`` by farthest-view sampling from row ``start`` on, in order.

    FisherRF's choice of the initial views (``active/schema.py``): pool index 0, then greedy max-min.
    """
    others = np.delete(np.arange(len(centers)), start)
    if k == 1:
        return np.array([start], dtype=np.int64)
    order, _ = farthest_order(centers[others], centers[[start]], k - 1)
    return np.concatenate([[start], others[order]])


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
            "Greedy max-min of Euclidean distances between camera centres, as FisherRF's initial views (commit b747328). "
            "The paper lists it as an oracle; it sees no image, so it is ranked as a method."
        ),
        higher_is_worse=True,
        build=FarthestSelector,
    )
}
