"""The nine statistics against what a picture made for each of them must give, and against a slow twin."""

import numpy as np
import pytest

from avs.iqa.render_statistics.pixel_statistics import PIXEL_STATISTICS, pixel_statistics
from avs.iqa.resizing import ResizeSettings

AS_IT_IS = ResizeSettings(side="long", pixels=48)
LEAST = 1e-3


def named(images):
    """Return the statistics of images by name."""
    return dict(zip(PIXEL_STATISTICS, pixel_statistics(np.stack(images), AS_IT_IS).T, strict=True))


def noise(seed=0):
    return np.random.default_rng(seed).integers(0, 256, (32, 48, 3), dtype=np.uint8)


def test_one_colour_has_brightness_and_nothing_else():
    found = named([np.full((32, 48, 3), level, dtype=np.uint8) for level in (0, 51, 255)])
    np.testing.assert_allclose(found["brightness"], [0, 0.2, 1], atol=1e-6)
    np.testing.assert_allclose(found["contrast"], 0, atol=1e-6)
    np.testing.assert_allclose(found["saturation"], 0, atol=1e-6)
    np.testing.assert_allclose(found["flat"], 1)
    for name in ("gradient", "gradient_half", "gradient_quarter", "laplacian"):
        np.testing.assert_allclose(found[name], np.log(LEAST), rtol=1e-3)


def test_detail_is_measured_as_a_loop_measures_it():
    image = noise()
    grey = (image / 255.0) @ [0.299, 0.587, 0.114]
    rows, columns = grey.shape
    lengths = [
        np.hypot(grey[y + 1, x] - grey[y, x], grey[y, x + 1] - grey[y, x])
        for y in range(rows - 1)
        for x in range(columns - 1)
    ]
    curves = [
        abs(grey[y - 1, x] + grey[y + 1, x] + grey[y, x - 1] + grey[y, x + 1] - 4 * grey[y, x])
        for y in range(1, rows - 1)
        for x in range(1, columns - 1)
    ]
    found = named([image])
    mean, root = np.mean(lengths), np.sqrt(np.mean(np.square(lengths)))
    assert found["gradient"] == pytest.approx(np.log(mean + LEAST), rel=1e-5)
    assert found["laplacian"] == pytest.approx(np.log(np.mean(curves) + LEAST), rel=1e-5)
    assert found["sharpness_spread"] == pytest.approx(np.log((root + LEAST) / (mean + LEAST)), rel=1e-4)
    assert found["flat"] == pytest.approx(np.mean(np.array(lengths) < 0.01))
    assert found["contrast"] == pytest.approx(grey.std(), rel=1e-5)
    assert found["saturation"] == pytest.approx(np.mean(image.max(2) / 255.0 - image.min(2) / 255.0), rel=1e-5)


def test_a_blurred_picture_has_less_fine_detail():
    sharp = noise()
    blurred = sharp.reshape(16, 2, 24, 2, 3).mean((1, 3)).repeat(2, 0).repeat(2, 1).astype(np.uint8)
    found = named([sharp, blurred])
    assert found["gradient"][1] < found["gradient"][0]
    np.testing.assert_allclose(found["gradient_half"][1], found["gradient_half"][0], atol=0.02)


def test_an_image_has_the_same_statistics_in_any_company():
    images = [noise(seed) for seed in range(3)]
    together = pixel_statistics(np.stack(images), AS_IT_IS)
    alone = np.concatenate([pixel_statistics(image[None], AS_IT_IS) for image in images])
    np.testing.assert_allclose(together, alone, rtol=1e-6)
