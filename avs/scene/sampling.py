"""Farthest-view sampling: greedy max-min of distances between camera centres."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import FloatArray


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
