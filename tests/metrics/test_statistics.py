"""Summaries against values by hand and scipy's bootstrap."""

import numpy as np
import pytest
from scipy.stats import bootstrap

from metrics.statistics import Interval, Summary, paired_bootstrap, summarise
from tests import tolerances


def test_mean_over_seeds_of_the_mean_over_scenes_with_its_standard_deviation():
    # Scene means 20, 21 and 22: the large difference between scenes does not enter the spread.
    assert summarise([[10, 30], [11, 31], [12, 32]]) == Summary(21.0, 1.0)


def test_one_seed_has_no_spread():
    assert summarise([[10.0, 30.0]]) == Summary(20.0, None)


@pytest.mark.parametrize("values", [[], [1.0], [[]], [[1.0, np.nan]], [[np.inf]]])
def test_values_must_be_a_full_table(values):
    with pytest.raises(ValueError, match="seeds, scenes"):
        summarise(values)


def test_bootstrap_of_one_seed_equals_scipy():
    differences = np.random.default_rng(3).normal(0.4, 1.0, 12)
    interval = paired_bootstrap(list(differences), resamples=100_000)
    expected = bootstrap((differences,), np.mean, method="percentile", n_resamples=100_000, rng=4).confidence_interval
    assert interval.difference == pytest.approx(differences.mean())
    assert interval.low == pytest.approx(expected.low, abs=tolerances.BOOTSTRAP)
    assert interval.high == pytest.approx(expected.high, abs=tolerances.BOOTSTRAP)


def test_two_levels_have_the_variance_of_theory():
    # The variance of the two-level bootstrap mean with S scenes and n seeds is
    # var(scene means)/S + mean(var within)/(S n), both with divisor n; a normal interval of it is wide enough here.
    values = np.random.default_rng(5).normal(0.0, 1.0, (40, 3)) + np.random.default_rng(6).normal(0, 1, (40, 1))
    variance = values.mean(axis=1).var() / 40 + values.var(axis=1).mean() / (40 * 3)
    interval = paired_bootstrap(list(values), resamples=50_000)
    assert interval.high - interval.low == pytest.approx(2 * 1.96 * variance**0.5, rel=tolerances.BOOTSTRAP_WIDTH)


def test_three_scenes_and_one_seed_span_the_differences():
    assert paired_bootstrap([[1.0], [2.0], [6.0]]) == Interval(3.0, 1.0, 6.0)


def test_one_scene_draws_its_seeds_and_one_difference_has_no_interval():
    interval = paired_bootstrap([[1.0, 2.0, 3.0]])
    assert (interval.low, interval.high) == (1.0, 3.0)
    assert paired_bootstrap([[1.0]]) is None


def test_resampling_is_seeded():
    differences = [[0.1, 0.4], [0.3], [-0.2, 0.0, 0.5]]
    assert paired_bootstrap(differences) == paired_bootstrap(differences)
    assert paired_bootstrap(differences, seed=1) != paired_bootstrap(differences, seed=2)


@pytest.mark.parametrize("differences", [[], [[]], [[1.0], []], [[np.nan]]])
def test_unfit_differences_are_refused(differences):
    with pytest.raises(ValueError, match="differences"):
        paired_bootstrap(differences)
