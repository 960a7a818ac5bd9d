"""The regression finds coefficients that it was made from, whatever the level of a moment; and its file."""

import dataclasses

import numpy as np
import pytest
from factories import with_one_bit_flipped

from avs.iqa.render_statistics.regression_file import (
    FittedRegressions,
    RegressionFacts,
    read_regressions,
    write_regressions,
)
from avs.iqa.render_statistics.regression_settings import RegressionSettings
from avs.iqa.render_statistics.ssim_regression import Sample, fit_regression
from avs.system.errors import UserError

TRUE = np.array([0.05, -0.02, 0.0])


def sample(seed, size=60, moments=4):
    """Candidates whose SSIM is linear within a moment; between moments statistics and SSIM run against each other."""
    rng = np.random.default_rng(seed)
    moment = np.repeat(np.arange(moments), size // moments)
    statistics = rng.normal(size=(size, 3)) - moment[:, None]
    return Sample(statistics, 0.5 + 0.3 * moment + (statistics + moment[:, None]) @ TRUE, moment)


def test_coefficients_are_those_within_moments():
    regression = fit_regression([sample(1), sample(2, size=20)], ("a", "b", "c"), penalty=1e-9)
    np.testing.assert_allclose(regression.coefficients / regression.deviations, TRUE, atol=1e-6)


def test_the_level_is_that_of_the_scenes():
    samples = [sample(1), sample(2)]
    regression = fit_regression(samples, ("a", "b", "c"), penalty=1e-6)
    predicted = np.mean([regression.predict(each.statistics).mean() for each in samples])
    assert predicted == pytest.approx(np.mean([each.similarity.mean() for each in samples]))


def test_a_constant_statistic_does_no_harm():
    constant = sample(1)
    constant.statistics[:, 2] = 3.0
    regression = fit_regression([constant], ("a", "b", "c"), penalty=1e-3)
    assert regression.coefficients[2] == 0
    assert np.isfinite(regression.predict(constant.statistics)).all()


@pytest.fixture
def fitted():
    regression = fit_regression([sample(1)], ("a", "b", "c"), penalty=1e-3)
    facts = RegressionFacts(
        settings=RegressionSettings(), scenes=1, candidates=60, held_out=0, candidate_spearman={"seen": 0.5}
    )
    return FittedRegressions({"seen": regression, "pixels": regression}, facts)


def test_a_file_is_read_as_it_was_written(fitted, tmp_path):
    path = tmp_path / "statistics.safetensors"
    write_regressions(path, fitted)
    read = read_regressions(path)
    assert read.facts == fitted.facts
    statistics = sample(3).statistics
    for name in ("seen", "pixels"):
        expected = fitted.regressions[name].predict(statistics)
        np.testing.assert_array_equal(read.regressions[name].predict(statistics), expected)


def test_a_damaged_file_is_one_line(fitted, tmp_path):
    path = tmp_path / "statistics.safetensors"
    write_regressions(path, fitted)
    content = path.read_bytes()
    for changed in (content[:50], b"PK\x03\x04" * 50, *with_one_bit_flipped(content)):
        path.write_bytes(changed)
        with pytest.raises(UserError) as caught:
            read_regressions(path)
        assert "\n" not in str(caught.value)


def test_parts_that_do_not_fit_together_are_refused(fitted, tmp_path):
    short = dataclasses.replace(fitted.regressions["seen"], columns=("a", "b"))
    path = tmp_path / "statistics.safetensors"
    write_regressions(path, FittedRegressions({"seen": short, "pixels": short}, fitted.facts))
    with pytest.raises(UserError, match="seen is not 2 finite numbers"):
        read_regressions(path)
