"""Full-reference image metrics: PSNR and SSIM.

Every function takes two images of equal shape ``[height, width, 3]``: floating point in 0..1, or ``uint8``, which is
divided by 255. All are symmetric in the two images. Float images from a renderer are to be clipped to 0..1 by the
caller, as the 3DGS evaluation does; values farther outside than rounding explains are an error, because the metric of
an image on the wrong scale is a plausible wrong number.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.floating[Any]] | npt.NDArray[np.uint8]
FloatArray = npt.NDArray[np.float64]

PSNR_CAP = 100.0
"""Decibels given where the PSNR is higher, and to identical images, whose infinity JSON cannot carry.

Out of reach of a rendering: an 8-bit image of 480x320 pixels with four values wrong by one level has 98.7 dB.
"""

_WINDOW_TAPS = 11
_WINDOW_SIGMA = 1.5
_RADIUS = _WINDOW_TAPS // 2
_C1 = 0.01**2
_C2 = 0.03**2
_RANGE_SLACK = 1e-4
# Lines per strip and columns per block: all intermediate arrays of a strip stay in the level-2 cache (480x320, one
# thread: 19 ms, against 36 ms with whole images, and 64 ms for the blurs alone by scipy.ndimage).
_STRIP = 32
_BLOCK = 16


def psnr(image: Image, reference: Image) -> float:
    """Return the peak signal-to-noise ratio over all pixels and channels, in decibels, at most ``PSNR_CAP``.

    ``10 log10(1 / MSE)`` with one mean squared error for the whole image, as ``metrics.py`` of 3DGS computes it.

    Args:
        image: ``[height, width, 3]``.
        reference: ``[height, width, 3]``.

    Raises:
        ValueError: wrong shapes, types or value ranges.
    """
    return _decibels(float(np.mean(np.square(_difference(image, reference)))))


def psnr_per_channel(image: Image, reference: Image) -> float:
    """Return the mean over the three channels of each channel's PSNR, in decibels.

    The variant that FisherRF's training loop prints (its ``[3, H, W]`` tensor is taken as three rows). By the convexity
    of the logarithm it is never lower than ``psnr``. Each channel is capped at ``PSNR_CAP``.

    Args:
        image: ``[height, width, 3]``.
        reference: ``[height, width, 3]``.

    Raises:
        ValueError: wrong shapes, types or value ranges.
    """
    errors = np.mean(np.square(_difference(image, reference)), axis=(0, 1))
    return float(np.mean([_decibels(float(error)) for error in errors]))


def ssim_map(image: Image, reference: Image) -> FloatArray:
    """Return the structural similarity at every pixel, mean over the channels.

    Wang et al. 2004, equation 13, in the convention of 3DGS: Gaussian window of 11x11 taps with sigma 1.5, biased local
    variances, C1 = 0.01^2, C2 = 0.03^2, and zero padding: beyond the border both images are black, which makes the
    border more similar than other conventions have it.

    Args:
        image: ``[height, width, 3]``.
        reference: ``[height, width, 3]``.

    Returns:
        ``[height, width]`` float64 in -1..1; 1 where the windows are equal.

    Raises:
        ValueError: wrong shapes, types or value ranges.
    """
    check_pair(image, reference)
    first, second = _padded(image), _padded(reference)
    height, width, _ = image.shape
    similarity = np.empty((first.shape[1] - 2 * _RADIUS, first.shape[2] - 2 * _RADIUS))
    for top in range(0, len(similarity), _STRIP):
        lines = slice(top, top + _STRIP + 2 * _RADIUS)
        channels = [_strip_similarity(first[channel, lines], second[channel, lines]) for channel in range(3)]
        similarity[top : top + _STRIP] = (channels[0] + channels[1] + channels[2]) / 3.0
    return similarity[:height, :width].copy()


def ssim(image: Image, reference: Image) -> float:
    """Return the mean of ``ssim_map`` over all pixels.

    Args:
        image: ``[height, width, 3]``.
        reference: ``[height, width, 3]``.

    Raises:
        ValueError: wrong shapes, types or value ranges.
    """
    return float(np.mean(ssim_map(image, reference)))


def _strip_similarity(first: FloatArray, second: FloatArray) -> FloatArray:
    """SSIM of a strip's inner lines in one channel; only the sum of the variances enters, so four blurs suffice."""
    moments = np.stack([first, second, first * first + second * second, first * second])
    mean_first, mean_second, mean_squares, mean_product = _blur(moments)
    product = mean_first * mean_second
    squares = mean_first * mean_first + mean_second * mean_second
    numerator = (2.0 * product + _C1) * (2.0 * (mean_product - product) + _C2)
    denominator = (squares + _C1) * (mean_squares - squares + _C2)
    blocks: FloatArray = numerator / denominator
    return blocks.swapaxes(0, 1).reshape(_STRIP, -1)


def _blur(strips: FloatArray) -> FloatArray:
    """Blur ``[n, lines + 10, columns + 10]`` to ``[n, blocks, lines, columns of a block]``.

    Each of the two separable passes multiplies by a banded matrix, which BLAS does several times faster than a loop
    over the taps; the second pass takes overlapping blocks of columns, so that the band stays narrow.
    """
    vertical = np.matmul(_band(_STRIP), strips)
    span = _BLOCK + 2 * _RADIUS
    windows = np.lib.stride_tricks.sliding_window_view(vertical, span, axis=2)[:, :, ::_BLOCK]
    blurred: FloatArray = np.matmul(windows.swapaxes(1, 2), _band(_BLOCK).T)
    return blurred


@functools.cache
def _band(size: int) -> FloatArray:
    """Banded matrix ``[size, size + taps - 1]`` whose row i holds the window from column i on."""
    offsets = np.arange(_WINDOW_TAPS) - _RADIUS
    window = np.exp(-np.square(offsets) / (2.0 * _WINDOW_SIGMA**2))
    window /= window.sum()
    band = np.zeros((size, size + _WINDOW_TAPS - 1))
    for row in range(size):
        band[row, row : row + _WINDOW_TAPS] = window
    band.flags.writeable = False
    return band


def _padded(image: Image) -> FloatArray:
    """Return ``[3, lines + 10, columns + 10]`` in 0..1: zeros around, filled up to whole strips and blocks."""
    height, width, _ = image.shape
    lines, columns = -(-height // _STRIP) * _STRIP, -(-width // _BLOCK) * _BLOCK
    padded = np.zeros((3, lines + 2 * _RADIUS, columns + 2 * _RADIUS))
    inner = padded[:, _RADIUS : _RADIUS + height, _RADIUS : _RADIUS + width]
    inner[...] = image.transpose(2, 0, 1)
    if image.dtype == np.uint8:
        inner /= 255.0
    return padded


def _difference(image: Image, reference: Image) -> FloatArray:
    """Return image - reference as float64 in -1..1."""
    check_pair(image, reference)
    first, second = (
        array / 255.0 if array.dtype == np.uint8 else array.astype(np.float64) for array in (image, reference)
    )
    difference: FloatArray = first - second
    return difference


def _decibels(mean_squared_error: float) -> float:
    smallest = 10.0 ** (-PSNR_CAP / 10.0)
    return float(-10.0 * np.log10(max(mean_squared_error, smallest)))


def check_pair(image: Image, reference: Image) -> None:
    """Check that two images can be compared.

    Raises:
        ValueError: a shape is not ``[height, width, 3]``, the shapes differ, a type is neither floating point nor
            uint8, or a value is not in 0..1 (uint8 aside).
    """
    for name, array in (("image", image), ("reference", reference)):
        if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
            raise ValueError(f"{name} has the shape {array.shape}; it must be [height, width, 3]")
        if array.dtype == np.uint8:
            continue
        if not np.issubdtype(array.dtype, np.floating):
            raise ValueError(f"{name} is of type {array.dtype}; it must be floating point in 0..1 or uint8")
        low, high = float(array.min()), float(array.max())
        if not (low >= -_RANGE_SLACK and high <= 1.0 + _RANGE_SLACK):  # in this form it refuses NaN, too
            raise ValueError(f"{name} has values from {low:g} to {high:g}; they must lie in 0..1")
    if image.shape != reference.shape:
        raise ValueError(f"image is {image.shape} and reference {reference.shape}; they must have one shape")
