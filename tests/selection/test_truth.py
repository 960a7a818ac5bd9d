"""What the hidden photographs say of candidates, against slow twins."""

import numpy as np
import pytest
from factories import named_views, ring, state_of

from avs.representations.gaussians.gaussian_settings import Densification, GaussianSettings, InitialPoints
from avs.representations.gaussians.initialization import PointCloud
from avs.representations.gaussians.splats import GaussianSplats
from avs.selection.contract import Truth
from avs.selection.truth import gains, hidden, sample, true_metrics
from metrics.image import ssim
from tests import tolerances

SETTINGS = GaussianSettings(
    iterations=60,
    sh_degree=1,
    points=InitialPoints(random_count=60),
    densification=Densification(start=5, every=10, until=60),
)


def photographed(seed, count, size=(32, 24)):
    """Views of random photographs."""
    rng = np.random.default_rng(seed)
    images = tuple(rng.integers(0, 256, (size[1], size[0], 3), dtype=np.uint8) for _ in range(count))
    return named_views(ring(count, radius=3.0 + seed, size=size), images)


def fitted(captured):
    rng = np.random.default_rng(0)
    splats = GaussianSplats(PointCloud(rng.normal(size=(40, 3)), rng.random((40, 3))), 1.0, SETTINGS, rng, "cpu")
    splats.fit(captured, 12)
    return splats


@pytest.fixture
def state():
    captured, candidates, test = photographed(1, 4), photographed(2, 11), photographed(3, 3)
    truth = Truth(candidates, test)
    return state_of(fitted(captured), captured, candidates.cameras, np.random.default_rng(0), 0, truth)


def looped_psnr(image, photograph):
    return 10 * np.log10(1 / np.mean((image.astype(float) - photograph / 255) ** 2))


def test_true_metrics_compare_each_candidate_with_its_photograph(state):
    psnr, similarity = true_metrics(state, ["psnr", "ssim"])
    for row in range(11):
        image = state.representation.render(state.candidates[row]).rgb[0]
        photograph = state.truth.candidates.images[row]
        assert psnr[row] == pytest.approx(looped_psnr(image, photograph), abs=tolerances.PSNR_FLOAT64)
        assert similarity[row] == ssim(image, photograph)


def test_photographs_of_several_sizes_are_compared(state):
    small, large = photographed(4, 2, size=(16, 12)), photographed(5, 3)
    mixed = small.extended(large)[[2, 0, 3, 1, 4]]
    truth = Truth(mixed, mixed)
    (psnr,) = true_metrics(state_of(state.representation, state.captured, mixed.cameras, state.rng, 0, truth), ["psnr"])
    for row, photograph in enumerate(mixed.images):
        image = state.representation.render(mixed.cameras[row]).rgb[0]
        assert psnr[row] == pytest.approx(looped_psnr(image, photograph), abs=tolerances.PSNR_FLOAT64)


@pytest.mark.parametrize(("passes", "metric"), [(1, "psnr"), (2, "ssim")])
def test_gains_are_those_of_refitted_checkpoints(state, tmp_path, passes, metric):
    captured, (candidates, test) = state.captured, (state.truth.candidates, state.truth.test)
    state.representation.save(tmp_path / "state")

    def quality(views):
        splats = fitted(captured)
        splats.load(tmp_path / "state")
        splats.fit(views, passes * 5)
        values = []
        for row, photograph in enumerate(test.images):
            image = splats.render(test.cameras[row]).rgb[0]
            values.append(looped_psnr(image, photograph) if metric == "psnr" else ssim(image, photograph))
        return np.mean(values)

    expected = [quality(captured.extended(candidates[[row]])) - quality(captured) for row in range(3)]
    found = gains(state.representation, captured, candidates[[0, 1, 2]], test, passes, metric)
    np.testing.assert_allclose(found, expected, atol=tolerances.PSNR_FLOAT64)
    assert len(set(found.tolist())) == 3


def test_equal_candidates_have_equal_gains(state):
    twice = state.truth.candidates[[4, 4]]
    first, second = gains(state.representation, state.captured, twice, state.truth.test, 2)
    assert first == second


def test_a_seed_is_another_stream_and_the_same_one_each_time(state):
    arguments = (state.representation, state.captured, state.truth.candidates[[1, 2]], state.truth.test, 2)
    first, again, other, own = (gains(*arguments, seed=seed).tolist() for seed in (1, 1, 2, None))
    assert first == again
    assert len({tuple(found) for found in (first, other, own)}) == 3


def test_samples_are_ascending_without_repetition_and_at_most_all():
    rows = sample(np.random.default_rng(0), 30, 8)
    assert len(set(rows.tolist())) == 8
    assert (np.diff(rows) > 0).all()
    assert sample(np.random.default_rng(0), 5, 8).tolist() == [0, 1, 2, 3, 4]


def test_a_method_that_is_no_oracle_sees_no_photographs(state):
    blind = state_of(state.representation, state.captured, state.candidates, state.rng, 0)
    with pytest.raises(ValueError, match="oracle=True"):
        hidden(blind)
