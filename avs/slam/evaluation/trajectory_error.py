"""The error of a trajectory that was tracked (Sturm et al. 2012)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def absolute_trajectory_error(found: npt.NDArray[np.float64], truth: npt.NDArray[np.float64]) -> float:
    """Return the root mean square distance of positions after the rigid motion that makes it least.

    Args:
        found: ``[n, 3]`` positions, at least one.
        truth: ``[n, 3]`` in the same order.

    Returns:
        The error in the units of the positions. The motion has no scale: that of a map with depth is known.
    """
    first, second = found - found.mean(axis=0), truth - truth.mean(axis=0)
    left, _, right = np.linalg.svd(first.T @ second)
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right)) or 1.0])
    return float(np.sqrt(((first @ (left @ sign @ right) - second) ** 2).sum(axis=1).mean()))
