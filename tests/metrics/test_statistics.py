"""Summaries against values by hand, intervals against scipy, and their coverage by simulation."""

import numpy as np
import pytest
from scipy import stats

from metrics.statistics import Summary, interval_over_scenes, interval_over_seeds, spread_of, summarise
from tests import tolerances

DRAWS = 3000

# Scenes and seeds: of ci, of captures on a laptop, of the paper's protocol.
SIZES = [(2, 2), (3, 1), (3, 3), (4, 1), (5, 2), (8, 1), (8, 3), (9, 3)]
# Standard deviations over scenes and over seeds, in decibels.
LEVELS = [(0.3, 0.1), (0.3, 0.3), (0.1, 0.3), (0.0, 0.3)]

SHAPES = {
    "normal": lambda rng, size: rng.standard_normal(size),
    "heavy tails": lambda rng, size: rng.standard_t(3, size) / 3**0.5,
    "skewed": lambda rng, size: (rng.gamma(4.0, 1.0, size) - 4.0) / 2.0,  # skewness 1
}


def test_mean_over_seeds_of_the_mean_over_scenes_with_its_standard_deviation():
    # Scene means 20, 21 and 22: the large difference between scenes does not enter the spread.
    assert summarise([[10, 30], [11, 31], [12, 32]]) == Summary(21.0, 1.0)


@pytest.mark.parametrize("seeds", [1, 2])
def test_fewer_than_three_seeds_have_no_spread(seeds):
    assert summarise([[10.0, 30.0], [12.0, 32.0]][:seeds]).spread is None
    assert spread_of([1.0, 2.0, 3.0][:seeds]) is None
    assert spread_of([1.0, 2.0, 3.0]) == 1.0


@pytest.mark.parametrize("values", [[], [1.0], [[]], [[1.0, np.nan]], [[np.inf]]])
def test_values_must_be_a_full_table(values):
    with pytest.raises(ValueError, match="seeds, scenes"):
        summarise(values)


def test_over_scenes_equals_scipys_t_interval_of_the_scene_means():
    differences = np.random.default_rng(3).normal(0.4, 1.0, (5, 3))
    interval = interval_over_scenes(list(differences))
    expected = stats.ttest_1samp(differences.mean(axis=1), 0.0).confidence_interval(0.95)
    assert interval.difference == pytest.approx(differences.mean())
    assert (interval.low, interval.high) == pytest.approx(tuple(expected))
    assert interval.freedom == 4


def test_over_seeds_of_one_scene_equals_scipys_t_interval():
    differences = np.random.default_rng(4).normal(0.4, 1.0, 6)
    interval = interval_over_seeds([differences])
    expected = stats.ttest_1samp(differences, 0.0).confidence_interval(0.95)
    assert (interval.low, interval.high) == pytest.approx(tuple(expected))
    assert interval.freedom == pytest.approx(5)


def test_over_seeds_of_two_scenes_is_welchs_interval():
    """Half the difference of a sample and the negative of another is their mean: Welch's test with a sign turned."""
    rng = np.random.default_rng(5)
    first, second = rng.normal(0.2, 0.1, 3), rng.normal(0.6, 0.4, 4)
    interval = interval_over_seeds([first, second])
    welch = stats.ttest_ind(first, -second, equal_var=False)
    expected = welch.confidence_interval(0.95)
    assert (interval.low, interval.high) == pytest.approx((expected.low / 2, expected.high / 2))
    assert interval.freedom == pytest.approx(welch.df)


def test_what_cannot_be_covered_has_no_interval():
    assert interval_over_scenes([[1.0, 2.0, 3.0]]) is None
    assert interval_over_seeds([[1.0], [2.0]]) is None
    assert interval_over_seeds([[1.0, 2.0], [2.0]]) is None
    assert interval_over_scenes([[1.0]]) is None


def test_equal_differences_have_an_interval_without_width():
    for interval in (interval_over_scenes([[0.5, 0.5]] * 2), interval_over_seeds([[0.5, 0.5]] * 2)):
        assert (interval.low, interval.difference, interval.high) == (0.5, 0.5, 0.5)


@pytest.mark.parametrize("differences", [[], [[]], [[1.0], []], [[np.nan]]])
@pytest.mark.parametrize("function", [interval_over_scenes, interval_over_seeds])
def test_unfit_differences_are_refused(function, differences):
    with pytest.raises(ValueError, match="differences"):
        function(differences)


def coverage(function, draws, truth=0.0):
    """Return the share of the draws ``[n, scenes, seeds]`` whose interval holds the truth."""
    intervals = [function(draw) for draw in draws]
    return np.mean([interval.low <= truth <= interval.high for interval in intervals])


@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("shape", SHAPES)
def test_over_scenes_covers_other_scenes_and_seeds(shape, size):
    """Scenes and seeds are drawn anew each time; the truth is the mean over all of them."""
    scenes, seeds = size
    rng, draw = np.random.default_rng([scenes, seeds]), SHAPES[shape]
    allowed = tolerances.COVERAGE_COUNT if shape == "normal" else tolerances.COVERAGE_APPROXIMATE
    between, within = np.array(LEVELS).T[:, :, None, None, None]
    shape_of_all = (len(LEVELS), DRAWS // len(LEVELS), scenes)
    values = between * draw(rng, (*shape_of_all, 1)) + within * draw(rng, (*shape_of_all, seeds))
    assert coverage(interval_over_scenes, values.reshape(DRAWS, scenes, seeds)) >= 0.95 - allowed


@pytest.mark.parametrize("size", [size for size in SIZES if size[1] > 1] + [(1, 2), (1, 3)], ids=str)
@pytest.mark.parametrize("shape", SHAPES)
def test_over_seeds_covers_other_seeds_of_the_same_scenes(shape, size):
    """Seeds alone are drawn; the truth is the mean over these scenes. Noise differs between scenes by a factor of 3."""
    scenes, seeds = size
    rng = np.random.default_rng([scenes, seeds])
    expected = rng.normal(0.0, 0.5, scenes)
    noise = np.linspace(0.1, 0.3, scenes) if scenes > 1 else np.array([0.2])
    values = expected[:, None] + noise[:, None] * SHAPES[shape](rng, (DRAWS, scenes, seeds))
    covered = coverage(interval_over_seeds, values, expected.mean())
    assert covered >= 0.95 - tolerances.COVERAGE_APPROXIMATE
