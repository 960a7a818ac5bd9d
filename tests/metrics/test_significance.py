"""Tests of many pairs against scipy, tables of the literature and by simulation; the scenes that a comparison takes."""

import itertools
import math

import numpy as np
import pytest
from scipy import stats

from metrics.significance import average_ranks, deviation_limits, holm, p_value, scenes_needed
from metrics.statistics import interval_over_scenes, interval_over_seeds
from tests import tolerances


def test_the_p_value_of_an_interval_is_that_of_students_test():
    differences = np.random.default_rng(0).normal(0.4, 1.0, (5, 3))
    expected = stats.ttest_1samp(differences.mean(axis=1), 0.0).pvalue
    assert p_value(interval_over_scenes(list(differences))) == pytest.approx(expected)
    assert p_value(interval_over_scenes([[0.5], [0.5]])) == 0.0
    assert p_value(interval_over_scenes([[0.0], [0.0]])) == 1.0


def test_holms_correction_by_hand():
    # In ascending order 0.005 * 4, 0.01 * 3, 0.03 * 2, and 0.04, which cannot be below the one before.
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.9, 0.8]) == [1.0, 1.0]
    assert holm([]) == []


@pytest.mark.parametrize(("scenes", "seeds"), [(2, 2), (3, 3), (4, 1), (9, 3)])
def test_false_findings_among_all_pairs_stay_rare(scenes, seeds):
    """Eight methods that do not differ, on scenes whose first has three times the noise of the others."""
    rng, draws = np.random.default_rng(1), 200
    deviations = np.where(np.arange(scenes) == 0, 3.0, 1.0)[:, None]
    found = {interval_over_scenes: 0, interval_over_seeds: 0}
    for _ in range(draws):
        values = rng.standard_normal((8, scenes, seeds)) * deviations
        for test in found:
            intervals = [test(list(one - other)) for one, other in itertools.combinations(values, 2)]
            found[test] += any(
                each <= 0.05 for each in holm([p_value(interval) for interval in intervals if interval is not None])
            )
    assert max(found.values()) / draws <= 0.05 + tolerances.FALSE_FINDINGS


def test_ranks_by_hand():
    ranks = average_ranks([[3.0, 2.0, 1.0], [3.0, 3.0, 5.0]], higher_is_better=True)
    assert ranks.ranks == (1.75, 2.25, 2.0)
    lower = average_ranks([[3.0, 2.0, 1.0], [3.0, 3.0, 5.0]], higher_is_better=False)
    assert lower.ranks == (2.25, 1.75, 2.0)


@pytest.mark.parametrize(("methods", "quantile"), [(2, 1.960), (5, 2.728), (10, 3.164)])
def test_the_critical_difference_has_the_quantiles_of_demsars_table(methods, quantile):
    values = np.random.default_rng(2).normal(size=(14, methods))
    expected = quantile * math.sqrt(methods * (methods + 1) / (6 * 14))
    found = average_ranks(values, higher_is_better=True)
    assert found.critical == pytest.approx(expected, abs=tolerances.NEMENYI_TABLE)
    assert average_ranks(values[:1], higher_is_better=True).critical == math.inf


def test_friedmans_test_is_scipys_where_blocks_are_many():
    values = np.random.default_rng(3).normal(size=(40, 5)) + np.linspace(0.0, 0.6, 5)
    expected = stats.friedmanchisquare(*values.T).pvalue
    assert average_ranks(values, higher_is_better=True).p_value == pytest.approx(expected, abs=tolerances.PERMUTATIONS)


def test_three_methods_in_one_order_on_two_scenes_are_no_finding():
    """One in six permutations gives the same order again; the chi-squared limit would say 0.14."""
    values = [[3.0, 2.0, 1.0], [30.0, 20.0, 10.0]]
    found = average_ranks(values, higher_is_better=True)
    assert found.p_value == pytest.approx(1 / 6, abs=tolerances.PERMUTATIONS)


@pytest.mark.parametrize("values", [[], [1.0, 2.0], [[1.0]], [[1.0, math.nan]]])
def test_ranks_need_a_full_table(values):
    with pytest.raises(ValueError, match="blocks, methods"):
        average_ranks(values, higher_is_better=True)


@pytest.mark.parametrize(("difference", "scenes"), [(0.5, 34), (1.0, 10), (0.2, 199)])
def test_scenes_needed_are_those_of_the_literature(difference, scenes):
    """Cohen, Statistical power analysis, paired two-sided tests at 5 % with a power of 80 %."""
    assert scenes_needed(difference, 1.0) == scenes


def test_so_many_scenes_find_the_difference_in_four_of_five_runs():
    scenes, rng = scenes_needed(0.63, 0.6), np.random.default_rng(4)
    shares = [
        np.mean(stats.ttest_1samp(rng.normal(0.63, 0.6, (4000, number)), 0.0, axis=1).pvalue <= 0.05)
        for number in (scenes - 1, scenes)
    ]
    assert shares[0] < 0.8 + tolerances.POWER
    assert shares[1] > 0.8 - tolerances.POWER


def test_scenes_needed_at_the_ends():
    assert scenes_needed(0.0, 1.0) is None
    assert scenes_needed(0.001, 1.0) is None
    assert scenes_needed(0.1, 0.0) == 2
    assert scenes_needed(1000.0, 1.0) == 2
    found = [scenes_needed(difference, 1.0) for difference in np.geomspace(0.09, 100.0, 60)]
    assert found == sorted(found, reverse=True)


def test_a_standard_deviation_of_three_scenes_is_hardly_known():
    assert deviation_limits(1.0, 3) == pytest.approx((0.5207, 6.2847), abs=1e-4)
    rng = np.random.default_rng(5)
    estimates = rng.standard_normal((4000, 5)).std(axis=1, ddof=1)
    low, high = np.transpose([deviation_limits(each, 5) for each in estimates])
    assert np.mean((low <= 1.0) & (high >= 1.0)) == pytest.approx(0.95, abs=tolerances.POWER)
