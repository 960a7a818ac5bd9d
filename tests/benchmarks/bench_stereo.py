"""Speed of dense stereo: million pixel x plane x view a second, beside OpenCV's StereoSGBM on the same rectified pairs.

Run from the root of the repository: ``python -m tests.benchmarks.bench_stereo``. A pair is a textured surface seen by
two cameras side by side, whose rows agree, so that the depths of a plane sweep are disparities: both programs try the
same ones. OpenCV compares by Birchfield and Tomasi's measure and block sums, and smooths along five paths; this suite
compares by normalised cross-correlation and smooths along four. PatchMatch, which OpenCV does not have, stands by
itself: million pixel x plane x view a second, a plane for each hypothesis.

Times are of the process's CPU on one thread, in interleaved rounds, and ratios are of times of one round. The mean
error in pixels tells whether both did the work.
"""

from __future__ import annotations

import argparse
import os
import time

for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import cv2  # noqa: E402
import numpy as np  # noqa: E402
from scipy import ndimage  # noqa: E402

from avs.scene.cameras import Cameras  # noqa: E402
from avs.sfm.depth_maps import Stereo, picture_of, refined  # noqa: E402
from avs.sfm.plane_sweep import sweep  # noqa: E402
from avs.sfm.semi_global import smoothed, winners  # noqa: E402
from avs.sfm.stereo_vectors import BORDER, packed  # noqa: E402
from avs.system.provenance import machine  # noqa: E402

PLANES = 64
SIZES = ((132, 176), (240, 320), (360, 480))
HYPOTHESES = 8
"""Planes that PatchMatch compares at a pixel in one visit: its own, four of neighbours, three of random changes."""


def rectified_pair(height, width, seed=0):
    """Return two grey pictures and the disparities ``[h, w]`` of the left one, in 8..48 pixels."""
    rng = np.random.default_rng(seed)
    texture = sum(
        ndimage.gaussian_filter(rng.normal(size=(height, width + 64)), sigma) * sigma for sigma in (0.7, 2, 5)
    )
    texture = np.clip(128 + 90 * texture, 0, 255)
    smooth = ndimage.gaussian_filter(rng.normal(size=(height, width)), 24)
    disparity = 28 + 20 * smooth / np.abs(smooth).max()
    rows, columns = np.indices((height, width))
    left = ndimage.map_coordinates(texture, [rows, columns + 64 - disparity], order=1)
    right = texture[:, 64 : 64 + width]
    return left.astype(np.uint8), right.astype(np.uint8), disparity


def swept(left, right):
    """Return the disparities of the left picture by plane sweep and semi-global matching."""
    height, width = left.shape
    # a disparity is an inverse depth where the focal length and the baseline are one pixel
    maps = np.array([[1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0]], dtype=np.float32)
    sizes = np.array([[0, height + 2 * BORDER, width + 2 * BORDER]], dtype=np.int64)
    planes = np.arange(PLANES, dtype=np.float32)
    costs = sweep(left, packed(right), sizes, maps, planes, height, width)
    volume = np.ascontiguousarray(costs[:, :, :width].transpose(1, 2, 0))
    return winners(smoothed(volume, left))


def pair_cameras(height, width):
    """Return two cameras of focal length 1 side by side, one unit apart: a disparity is an inverse depth."""
    matrix = np.array([[1.0, 0, width / 2], [0, 1.0, height / 2], [0, 0, 1]])
    transforms = np.tile(np.eye(4), (2, 1, 1))
    transforms[1, 0, 3] = -1
    return Cameras(transforms, np.stack([matrix] * 2), np.array([[width, height]] * 2, dtype=np.int64))


def visited(left, right, disparity):
    """Return the disparities of the left picture after one visit of all pixels by PatchMatch."""
    height, width = left.shape
    state = np.stack([disparity, 0 * disparity, 0 * disparity], axis=-1).astype(np.float32)
    pictures = [picture_of(left), picture_of(right)]
    pair = Stereo(pictures, pictures, pair_cameras(height, width), (0.5, float(PLANES)))
    return refined(pair, state, 0.5, 1, 1, 0).planes[..., 0]


def by_opencv(left, right):
    """Return the disparities of the left picture by StereoSGBM with blocks of 7 x 7."""
    matcher = cv2.StereoSGBM_create(
        minDisparity=0, numDisparities=PLANES, blockSize=7, P1=8 * 49, P2=32 * 49, mode=cv2.STEREO_SGBM_MODE_SGBM
    )
    return matcher.compute(left, right).astype(np.float32) / 16


def timed(function, *arguments):
    start = time.process_time()
    result = function(*arguments)
    return time.process_time() - start, result


def spread(values):
    """Return the median and the quartiles as text."""
    low, middle, high = np.percentile(values, [25, 50, 75])
    return f"{middle:.3f} [{low:.3f}-{high:.3f}]"


def measured(height, width, rounds):
    """Return a line of one size of pictures."""
    left, right, truth = rectified_pair(height, width)
    times = {"sweep": [], "opencv": [], "patch": []}
    for _ in range(rounds + 1):  # the first one compiles
        spent, ours = timed(swept, left, right)
        times["sweep"].append(spent)
        spent, theirs = timed(by_opencv, left, right)
        times["opencv"].append(spent)
        spent, finer = timed(visited, left, right, np.maximum(ours, 1))
        times["patch"].append(spent)
    work = {"sweep": PLANES, "opencv": PLANES, "patch": HYPOTHESES}
    rates = {name: height * width * work[name] / np.array(spent[1:]) / 1e6 for name, spent in times.items()}
    inside = np.s_[8:-8, PLANES:-8]
    known = theirs[inside] >= 0
    errors = [np.abs(one[inside] - truth[inside])[known].mean() for one in (ours, finer, theirs)]
    middle = [np.median(rates[name]) for name in ("sweep", "patch", "opencv")]
    ratios = [spread(rates[name] / rates["opencv"]) for name in ("sweep", "patch")]
    return (
        f"{width}x{height}  {middle[0]:6.0f} {middle[1]:7.1f} {middle[2]:6.0f}  {ratios[0]:>20}  {ratios[1]:>20}"
        f"  {errors[0]:.3f} {errors[1]:.3f} {errors[2]:.3f}"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7)
    rounds = parser.parse_args().rounds
    cv2.setNumThreads(1)
    print(machine("cpu")["processor"])
    print("size     million a second       ratio to OpenCV, median and quartiles    error in pixels")
    print("           sweep   patch OpenCV                 sweep                 patch  sweep patch OpenCV")
    for height, width in SIZES:
        print(measured(height, width, rounds), flush=True)


if __name__ == "__main__":
    main()
