"""PSNR and SSIM against scikit-image, a brute-force window, and values by hand."""

import numpy as np
import pytest
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from metrics.image import PSNR_CAP, psnr, psnr_per_channel, ssim, ssim_map
from tests import tolerances


def pair(height=45, width=70, seed=0):
    generator = np.random.default_rng(seed)
    rows, columns = np.mgrid[:height, :width]
    pattern = 0.5 + 0.4 * np.sin(rows / 5.0) * np.cos(columns / 3.0)
    reference = np.clip(pattern[..., None] * [1.0, 0.8, 0.6] + generator.normal(0, 0.05, (height, width, 3)), 0, 1)
    return np.clip(reference + generator.normal(0.02, 0.1, reference.shape), 0, 1), reference


def brute_force_ssim_map(image, reference):
    """Every window by itself, in float64, with zeros beyond the border."""
    offsets = np.arange(-5, 6)
    window = np.exp(-(offsets[:, None] ** 2 + offsets[None, :] ** 2) / (2 * 1.5**2))
    window /= window.sum()
    height, width, _ = image.shape
    first, second = (np.pad(array, ((5, 5), (5, 5), (0, 0))) for array in (image, reference))
    similarity = np.empty((height, width, 3))
    for row, column, channel in np.ndindex(height, width, 3):
        x = first[row : row + 11, column : column + 11, channel]
        y = second[row : row + 11, column : column + 11, channel]
        mean_x, mean_y = (window * x).sum(), (window * y).sum()
        variance_x, variance_y = (window * x * x).sum() - mean_x**2, (window * y * y).sum() - mean_y**2
        covariance = (window * x * y).sum() - mean_x * mean_y
        similarity[row, column, channel] = ((2 * mean_x * mean_y + 1e-4) * (2 * covariance + 9e-4)) / (
            (mean_x**2 + mean_y**2 + 1e-4) * (variance_x + variance_y + 9e-4)
        )
    return similarity.mean(axis=2)


# Sizes around the inner block sizes (16 columns, 32 lines), and smaller than the window.
@pytest.mark.parametrize(("height", "width"), [(45, 70), (32, 16), (33, 17), (31, 15), (7, 5), (1, 1)])
def test_ssim_map_equals_brute_force(height, width):
    image, reference = pair(height, width)
    similarity = ssim_map(image, reference)
    assert similarity.shape == (height, width)
    np.testing.assert_allclose(similarity, brute_force_ssim_map(image, reference), atol=tolerances.SSIM_FLOAT64)
    assert ssim(image, reference) == pytest.approx(similarity.mean(), abs=tolerances.SSIM_FLOAT64)


def test_ssim_map_equals_scikit_image_away_from_the_border():
    image, reference = pair(90, 120)
    _, expected = structural_similarity(
        image,
        reference,
        win_size=11,
        channel_axis=2,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        data_range=1.0,
        full=True,
    )
    inner = np.s_[5:-5, 5:-5]  # scikit-image mirrors at the border, 3DGS pads with zeros
    np.testing.assert_allclose(
        ssim_map(image, reference)[inner], expected.mean(axis=2)[inner], atol=tolerances.SSIM_FLOAT64
    )


def test_psnr_equals_scikit_image_and_the_closed_form():
    image, reference = pair()
    expected = peak_signal_noise_ratio(reference, image, data_range=1.0)
    assert psnr(image, reference) == pytest.approx(expected, abs=tolerances.PSNR_FLOAT64)
    black, grey = np.zeros((4, 6, 3)), np.full((4, 6, 3), 0.1)
    assert psnr(black, grey) == pytest.approx(20.0, abs=tolerances.PSNR_FLOAT64)


def test_psnr_per_channel_is_the_mean_of_three():
    image, reference = np.zeros((4, 6, 3)), np.zeros((4, 6, 3))
    image[...] = [0.1, 0.01, 0.001]
    assert psnr_per_channel(image, reference) == pytest.approx((20 + 40 + 60) / 3, abs=tolerances.PSNR_FLOAT64)
    error = (0.1**2 + 0.01**2 + 0.001**2) / 3
    assert psnr(image, reference) == pytest.approx(-10 * np.log10(error), abs=tolerances.PSNR_FLOAT64)


def test_identical_images_have_the_capped_psnr_and_ssim_one():
    image, _ = pair()
    assert psnr(image, image) == psnr_per_channel(image, image) == PSNR_CAP
    assert ssim(image, image) == pytest.approx(1.0, abs=tolerances.SSIM_FLOAT64)


@pytest.mark.parametrize("metric", [psnr, psnr_per_channel, ssim, ssim_map])
def test_metrics_are_symmetric_and_take_uint8(metric):
    image, reference = (np.round(array * 255).astype(np.uint8) for array in pair())
    value = metric(image, reference)
    np.testing.assert_array_equal(value, metric(reference, image))
    np.testing.assert_allclose(value, metric(image / 255.0, reference / 255.0), rtol=tolerances.UINT8_EQUALS_FLOAT)
    as_float32 = metric((image / 255.0).astype(np.float32), reference)
    np.testing.assert_allclose(value, as_float32, rtol=tolerances.FLOAT32_INPUT)


@pytest.mark.parametrize(
    ("image", "fault"),
    [
        (np.zeros((8, 8)), "shape"),
        (np.zeros((3, 8, 8)), "shape"),
        (np.zeros((0, 8, 3)), "shape"),
        (np.zeros((8, 9, 3)), "one shape"),
        (np.zeros((8, 8, 3), np.int64), "type"),
        (np.full((8, 8, 3), 255.0), "0..1"),
        (np.full((8, 8, 3), -0.1), "0..1"),
        (np.full((8, 8, 3), np.nan), "0..1"),
    ],
)
@pytest.mark.parametrize("metric", [psnr, psnr_per_channel, ssim_map])
def test_unfit_images_are_refused(metric, image, fault):
    with pytest.raises(ValueError, match=fault):
        metric(image, np.zeros((8, 8, 3)))
