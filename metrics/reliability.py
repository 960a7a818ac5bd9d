"""How far a measurement with noise can be trusted, from two measurements of the same things."""

from __future__ import annotations

import math


def spearman_brown(correlation: float, measurements: int = 2) -> float:
    """Return the reliability of the mean of several measurements from the correlation between single ones.

    Spearman (1910) and Brown (1910): k r / (1 + (k - 1) r), for measurements of equal error whose errors are
    independent.

    Args:
        correlation: of two measurements, in -1..1. One that is not positive says that nothing was measured: 0.
        measurements: how many the mean is of.

    Returns:
        The expected correlation of that mean with another of the same kind, in 0..1.

    Raises:
        ValueError: the correlation is not in -1..1, or there is no measurement.
    """
    if not -1.0 <= correlation <= 1.0 or measurements < 1:
        raise ValueError(f"a correlation of {correlation} and {measurements} measurements")
    positive = max(correlation, 0.0)
    return measurements * positive / (1.0 + (measurements - 1) * positive)


def correlation_bound(reliability: float) -> float:
    """Return the largest correlation that anything without error is expected to have with a measurement.

    Spearman's (1904) attenuation: the correlation with the true values, at most 1, times the root of the reliability.
    It is exact for Pearson's correlation, and an approximation for rank correlations.

    Raises:
        ValueError: the reliability is not in 0..1.
    """
    if not 0.0 <= reliability <= 1.0:
        raise ValueError(f"a reliability of {reliability}")
    return math.sqrt(reliability)
