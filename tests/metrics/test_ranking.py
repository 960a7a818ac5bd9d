"""Rank correlations against their definitions by plain loops, and where they are undefined."""

import numpy as np
import pytest

from metrics.ranking import kendall, spearman
from tests import tolerances


def looped_ranks(values):
    """Mean of the places that equal values share."""
    return [sum(1 for v in values if v < value) + (sum(1 for v in values if v == value) + 1) / 2 for value in values]


def looped_spearman(first, second):
    a, b = looped_ranks(first), looped_ranks(second)
    mean = (len(a) + 1) / 2
    product = sum((x - mean) * (y - mean) for x, y in zip(a, b, strict=True))
    return product / (sum((x - mean) ** 2 for x in a) * sum((y - mean) ** 2 for y in b)) ** 0.5


def looped_kendall(first, second):
    concordant = discordant = pairs_first = pairs_second = 0
    for i in range(len(first)):
        for j in range(i):
            a, b = np.sign(first[i] - first[j]), np.sign(second[i] - second[j])
            concordant += a * b > 0
            discordant += a * b < 0
            pairs_first += a != 0
            pairs_second += b != 0
    return (concordant - discordant) / (pairs_first * pairs_second) ** 0.5


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("values", [3, 6, 1000])
def test_correlations_follow_their_definition_with_and_without_ties(seed, values):
    rng = np.random.default_rng(seed)
    first, second = rng.integers(0, values, (2, 17)).astype(float)
    assert spearman(first, second).value == pytest.approx(looped_spearman(first, second), abs=tolerances.RANKING)
    assert kendall(first, second).value == pytest.approx(looped_kendall(first, second), abs=tolerances.RANKING)


@pytest.mark.parametrize("correlation", [spearman, kendall])
def test_only_the_order_counts(correlation):
    values = np.random.default_rng(0).normal(size=9)
    assert correlation(values, np.exp(values)).value == pytest.approx(1.0)
    assert correlation(values, -(values**3)).value == pytest.approx(-1.0)


@pytest.mark.parametrize("correlation", [spearman, kendall])
@pytest.mark.parametrize(
    ("first", "second", "reason"),
    [
        ([1.0, 1.0, 1.0], [1.0, 2.0, 3.0], "all values are equal"),
        ([1.0, 2.0, 3.0], [5.0, 5.0, 5.0], "all values are equal"),
        ([1.0, 2.0], [1.0, 2.0], "fewer than 3 candidates have both"),
        ([], [], "fewer than 3 candidates have both"),
    ],
)
def test_undefined_correlations_say_why(correlation, first, second, reason):
    found = correlation(first, second)
    assert (found.value, found.reason) == (None, reason)


@pytest.mark.parametrize("correlation", [spearman, kendall])
@pytest.mark.parametrize("second", [[1.0, 2.0], [1.0, 2.0, np.nan], [[1.0], [2.0], [3.0]]])
def test_unfit_values_are_refused(correlation, second):
    with pytest.raises(ValueError, match="finite"):
        correlation([1.0, 2.0, 3.0], second)
