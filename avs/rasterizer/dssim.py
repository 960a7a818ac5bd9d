"""L1 and D-SSIM of two images on the CPU: value and gradient by numba, one thread.

The blur is separable: each row is blurred along itself, then rows are blurred across. Channels are interleaved, so a
row of an image ``[height, width, 3]`` is ``3 width`` numbers and a horizontal neighbour lies 3 numbers away. Every
inner loop runs along a row and is vectorised by LLVM; at 480x320 the whole takes a few milliseconds, where ``conv2d``
and its backward take over 100.
"""

# numba finds the types of the compiled functions when they are first called.
# ruff: noqa: ANN001, ANN202
# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

from functools import partial

import numba
import numpy as np
import numpy.typing as npt

from avs.rasterizer.kernels import kernel

RADIUS = 5
"""The window has 11 pixels, as in Wang et al. 2004 and 3DGS."""

C1, C2 = 0.01**2, 0.03**2
"""The constants of SSIM for images in 0..1 (Wang et al. 2004, equation 13)."""

FloatArray = npt.NDArray[np.float32]

# Sums may be reordered, which the vector units need; the order is the same in every run on one kind of machine.
_kernel = partial(kernel, fastmath=True)
_inline = numba.njit(error_model="numpy", fastmath=True, inline="always")

_CHANNELS = 3
_MARGIN = RADIUS * _CHANNELS


def window() -> npt.NDArray[np.float64]:
    """Return the ``[11]`` weights of the Gaussian window of sigma 1.5; they sum to 1."""
    offsets = np.arange(-RADIUS, RADIUS + 1)
    weights: npt.NDArray[np.float64] = np.exp(-(offsets**2) / (2 * 1.5**2))
    return np.asarray(weights / weights.sum())


# Scalars, because LLVM vectorises the sums only when the weights are constants.
_W0, _W1, _W2, _W3, _W4, _W5 = (np.float32(weight) for weight in window()[: RADIUS + 1])
_C1, _C2, _TWO = np.float32(C1), np.float32(C2), np.float32(2)


def target_moments(target: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the window's mean of ``target`` ``[height, width, 3]`` and of its square, of the same shape."""
    height, width, _ = target.shape
    rows = np.ascontiguousarray(target).reshape(height, width * _CHANNELS)
    return _blur(rows).reshape(target.shape), _blur(rows * rows).reshape(target.shape)


def l1_dssim(
    image: FloatArray, target: FloatArray, moments: tuple[FloatArray, FloatArray], weight: float
) -> tuple[float, FloatArray]:
    """Return ``(1 - weight) L1 + weight (1 - SSIM)`` and its gradient with respect to ``image``.

    L1 is the mean absolute difference and SSIM the mean of the SSIM map, both over pixels and channels, with zero
    padding, as in 3DGS (arXiv 2308.04079, equation 7).

    Args:
        image: ``[height, width, 3]``, contiguous.
        target: ``[height, width, 3]``, contiguous.
        moments: what ``target_moments(target)`` returns.
        weight: of D-SSIM, in 0..1.

    Returns:
        The value, and the gradient ``[height, width, 3]``.
    """
    shape = (image.shape[0], image.shape[1] * _CHANNELS)
    mean, square = (moment.reshape(shape) for moment in moments)
    absolute, similarity, gradient = _l1_dssim(
        image.reshape(shape), target.reshape(shape), mean, square, np.float32(weight)
    )
    value = (1 - weight) * absolute / image.size + weight * (1 - similarity / image.size)
    return value, gradient.reshape(image.shape)


@_inline
def _along(row, out, length):
    """Blur one row into ``out``; ``row`` has ``_MARGIN`` zeros at each end."""
    for j in range(length):
        out[j] = (
            _W0 * (row[j] + row[j + 30])
            + _W1 * (row[j + 3] + row[j + 27])
            + _W2 * (row[j + 6] + row[j + 24])
            + _W3 * (row[j + 9] + row[j + 21])
            + _W4 * (row[j + 12] + row[j + 18])
            + _W5 * row[j + 15]
        )


@_inline
def _across(plane, i, out, length):
    """Blur rows i..i+10 of ``plane`` into ``out``; the plane has ``RADIUS`` rows of zeros at each end."""
    # In two loops: LLVM checks at most eight pairs of arrays for overlap before it vectorises.
    a, b, c, d, e = plane[i], plane[i + 1], plane[i + 5], plane[i + 9], plane[i + 10]
    for j in range(length):
        out[j] = _W0 * (a[j] + e[j]) + _W1 * (b[j] + d[j]) + _W5 * c[j]
    a, b, c, d, e, f = plane[i + 2], plane[i + 3], plane[i + 4], plane[i + 6], plane[i + 7], plane[i + 8]
    for j in range(length):
        out[j] += _W2 * (a[j] + f[j]) + _W3 * (b[j] + e[j]) + _W4 * (c[j] + d[j])


@_kernel
def _blur(rows):
    height, length = rows.shape
    plane = np.zeros((height + 2 * RADIUS, length), np.float32)
    padded = np.zeros(length + 2 * _MARGIN, np.float32)
    for i in range(height):
        padded[_MARGIN : _MARGIN + length] = rows[i]
        _along(padded, plane[i + RADIUS], length)
    out = np.empty((height, length), np.float32)
    for i in range(height):
        _across(plane, i, out[i], length)
    return out


@_kernel
def _l1_dssim(image, target, target_mean, target_square, weight):
    """Return the sums of the absolute differences and of the SSIM map, and the gradient of the loss.

    With E the blur, the map is ``ab / (cd)``; a = 2 Ex Ey + C1, b = 2 (Exy - Ex Ey) + C2, c = Ex^2 + Ey^2 + C1,
    d = Exx - Ex^2 + Eyy - Ey^2 + C2. Its derivatives with respect to Ex, Exx and Exy are blurred again: with zero
    padding and a symmetric window the blur is its own adjoint.
    """
    height, length = image.shape
    # Row i of the image blurred along itself lies at i + 2 RADIUS. Row i of the derivatives takes the place i + RADIUS,
    # which nobody reads any more by then: half the memory traffic of two buffers.
    planes = np.zeros((3, height + 3 * RADIUS, length), np.float32)
    padded = np.zeros((3, length + 2 * _MARGIN), np.float32)
    for i in range(height):
        _moments_row(image[i], target[i], padded[0, _MARGIN:], padded[1, _MARGIN:], padded[2, _MARGIN:], length)
        for k in range(3):
            _along(padded[k], planes[k, i + 2 * RADIUS], length)

    blurred = np.empty((3, length), np.float32)
    inverse = np.empty(length, np.float32)
    similarity = 0.0
    for i in range(height):
        for k in range(3):
            _across(planes[k], i + RADIUS, blurred[k], length)
        similarity += _derivatives_row(
            blurred[0],
            blurred[1],
            blurred[2],
            target_mean[i],
            target_square[i],
            inverse,
            padded[0, _MARGIN:],
            padded[1, _MARGIN:],
            padded[2, _MARGIN:],
            length,
        )
        for k in range(3):
            _along(padded[k], planes[k, i + RADIUS], length)
    planes[:, height + RADIUS :] = 0

    gradient = np.empty((height, length), np.float32)
    l1_scale = (np.float32(1) - weight) / np.float32(image.size)
    ssim_scale = -weight / np.float32(image.size)
    absolute = 0.0
    for i in range(height):
        for k in range(3):
            _across(planes[k], i, blurred[k], length)
        absolute += _gradient_row(
            image[i], target[i], blurred[0], blurred[1], blurred[2], l1_scale, ssim_scale, gradient[i], length
        )
    return absolute, similarity, gradient


# Each loop below has one output: with more LLVM needs too many checks that arrays do not overlap, and leaves the loop
# scalar.


@_inline
def _moments_row(x, y, out_x, out_xx, out_xy, length):
    for j in range(length):
        out_x[j] = x[j]
    for j in range(length):
        out_xx[j] = x[j] * x[j]
    for j in range(length):
        out_xy[j] = x[j] * y[j]


@_inline
def _derivatives_row(ex, exx, exy, ey, eyy, inverse, by_ex, by_exx, by_exy, length):
    """Write the derivatives of the SSIM map of one row and return the row's sum of the map."""
    for j in range(length):
        mean_part = ex[j] * ex[j] + ey[j] * ey[j]
        inverse[j] = np.float32(1) / ((mean_part + _C1) * (exx[j] + eyy[j] - mean_part + _C2))
    for j in range(length):
        by_exy[j] = _TWO * (_TWO * ex[j] * ey[j] + _C1) * inverse[j]
    total = np.float32(0)
    for j in range(length):
        product = _TWO * ex[j] * ey[j]
        similarity = (product + _C1) * (_TWO * exy[j] - product + _C2) * inverse[j]
        total += similarity
        by_exx[j] = -similarity * (ex[j] * ex[j] + ey[j] * ey[j] + _C1) * inverse[j]
    for j in range(length):
        product = _TWO * ex[j] * ey[j]
        covariance_part = (_TWO * exy[j] - product + _C2) * inverse[j]
        similarity = (product + _C1) * covariance_part
        mean_part = ex[j] * ex[j] + ey[j] * ey[j] + _C1
        through_means = ey[j] * covariance_part - ex[j] * similarity / mean_part
        by_ex[j] = _TWO * (through_means - ex[j] * by_exx[j]) - ey[j] * by_exy[j]
    return total


@_inline
def _gradient_row(x, y, by_ex, by_exx, by_exy, l1_scale, ssim_scale, out, length):
    """Write one row of the gradient and return the row's sum of absolute differences."""
    total = np.float32(0)
    for j in range(length):
        difference = x[j] - y[j]
        total += abs(difference)
        sign = np.float32(difference > 0) - np.float32(difference < 0)
        out[j] = l1_scale * sign + ssim_scale * (by_ex[j] + _TWO * x[j] * by_exx[j] + y[j] * by_exy[j])
    return total
