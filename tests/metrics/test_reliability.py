"""The reliability of a mean of measurements, against sums over a covariance matrix and against a simulation."""

import math

import numpy as np
import pytest

from metrics.reliability import correlation_bound, spearman_brown


def correlation_of_means(correlation, measurements):
    """Correlate two means of parallel measurements of unit variance, entry by entry of their covariance matrix."""
    within = between = 0.0
    for first in range(measurements):
        for second in range(measurements):
            within += 1.0 if first == second else correlation
            between += correlation
    return between / within


@pytest.mark.parametrize("measurements", [1, 2, 3, 7])
@pytest.mark.parametrize("correlation", [0.0, 0.1, 0.5, 0.82, 1.0])
def test_the_mean_of_measurements_is_as_reliable_as_their_covariances_say(correlation, measurements):
    expected = correlation_of_means(correlation, measurements)
    assert spearman_brown(correlation, measurements) == pytest.approx(expected, rel=1e-12)


def test_two_measurements_by_hand():
    assert spearman_brown(0.5) == pytest.approx(2 / 3)
    assert correlation_bound(2 / 3) == pytest.approx(math.sqrt(2 / 3))


def test_what_is_measured_without_error_correlates_up_to_the_bound():
    rng = np.random.default_rng(0)
    true = rng.normal(size=200_000)
    measured = [true + 0.7 * rng.normal(size=true.size) for _ in range(2)]
    retest = float(np.corrcoef(measured)[0, 1])
    bound = correlation_bound(spearman_brown(retest))
    assert np.corrcoef(true, np.mean(measured, axis=0))[0, 1] == pytest.approx(bound, abs=0.005)


def test_no_agreement_is_no_reliability():
    assert spearman_brown(-0.4) == spearman_brown(-1.0) == spearman_brown(0.0) == 0.0
    assert correlation_bound(0.0) == 0.0


@pytest.mark.parametrize(("correlation", "measurements"), [(1.1, 2), (-1.1, 2), (0.5, 0), (float("nan"), 2)])
def test_what_is_no_correlation_is_refused(correlation, measurements):
    with pytest.raises(ValueError, match="a correlation of"):
        spearman_brown(correlation, measurements)
    with pytest.raises(ValueError, match="a reliability of"):
        correlation_bound(1.5)
