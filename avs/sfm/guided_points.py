"""Sparse points between known cameras, quickly: what dense stereo needs to know of depths and of common views.

A feature is compared with those near its epipolar line alone. Among so few, one that is clearly the nearest tends to be
right even in views far apart, of which few features would pass against all others. A point is seen by two views; tracks
through several make a better model, but tell nothing more of depths.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, FloatArray, IndexArray
from avs.scene.points import Points
from avs.scene.views import Views
from avs.sfm.sfm_settings import GuidedSettings
from avs.sfm.sparse import fundamental, near_pairs


@dataclass(frozen=True)
class Features:
    """SIFT features of a picture.

    Attributes:
        pixels: ``[f, 2]`` float64, columns and rows, (0.5, 0.5) in the middle of the first pixel.
        descriptors: ``[f, 128]`` float32, roots of SIFT's, of unit length (Arandjelovic and Zisserman 2012).
    """

    pixels: FloatArray
    descriptors: npt.NDArray[np.float32]


def guided_points(views: Views, settings: GuidedSettings) -> Points:
    """Return points that two of the views see; there may be none.

    Args:
        views: at least two, of known poses.
        settings: see there.
    """
    features = [features_of(image, settings.features) for image in views.images]
    positions, observations, count = [np.zeros((0, 3))], [np.zeros((0, 2), dtype=np.int64)], 0
    for pair in near_pairs(views.cameras, settings.partners):
        first, second = features[pair[0]], features[pair[1]]
        cameras = views.cameras[list(pair)]
        matches = guided_matches(first, second, cameras, settings)
        found = triangulated_pairs(first.pixels[matches[:, 0]], second.pixels[matches[:, 1]], cameras, settings)
        rows = np.arange(count, count + len(found))
        positions.append(found)
        observations.append(np.stack([np.repeat(rows, 2), np.tile(pair, len(found))], axis=1))
        count += len(found)
    return Points(np.concatenate(positions), np.zeros((count, 3), dtype=np.uint8), np.concatenate(observations))


def features_of(image: npt.NDArray[np.uint8], count: int) -> Features:
    """Return the ``count`` strongest SIFT features of a colour image, at most."""
    import cv2

    cv2.setNumThreads(1)  # as everywhere in a process of the workflow
    found: Any
    keypoints, found = cv2.SIFT.create(nfeatures=count, contrastThreshold=0.02).detectAndCompute(
        cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), None
    )
    if found is None:  # not a single feature
        return Features(np.zeros((0, 2)), np.zeros((0, 128), dtype=np.float32))
    pixels = np.array([keypoint.pt for keypoint in keypoints]) + 0.5
    shares = found / np.maximum(found.sum(axis=1, keepdims=True), 1e-9)
    return Features(pixels, np.sqrt(shares).astype(np.float32))


def guided_matches(first: Features, second: Features, cameras: Cameras, settings: GuidedSettings) -> IndexArray:
    """Return the pairs ``[m, 2]`` of features that are each other's nearest among those that the cameras allow.

    The second nearest of these has to be farther by one ratio, and the nearest of all others by another.
    """
    if not len(first.pixels) or not len(second.pixels):
        return np.zeros((0, 2), dtype=np.int64)
    matrix = fundamental(cameras).astype(np.float32)
    left, right = (
        np.concatenate([one.pixels, np.ones((len(one.pixels), 1))], axis=1).astype(np.float32)
        for one in (first, second)
    )
    lines, lines_back = left @ matrix.T, right @ matrix
    products = np.abs(lines @ right.T)
    reach = np.float32(settings.error) * np.sqrt((lines[:, :2] ** 2).sum(axis=1))[:, None]
    reach_back = np.float32(settings.error) * np.sqrt((lines_back[:, :2] ** 2).sum(axis=1))[None]
    likeness = first.descriptors @ second.descriptors.T
    nearest = -np.partition(-likeness, min(1, likeness.shape[1] - 1), axis=1)[:, :2]
    likeness[(products > reach) | (products > reach_back)] = -1
    best, rows = likeness.argmax(axis=1), np.arange(len(left))
    values = likeness[rows, best]
    mutual = likeness.argmax(axis=0)[best] == rows
    likeness[rows, best] = -1
    # of vectors of unit length the squared distance is two less twice the product
    clear = (2 - 2 * values) <= settings.ratio**2 * (2 - 2 * likeness.max(axis=1))
    others = np.where(values >= nearest[:, 0], nearest[:, -1], nearest[:, 0])
    distinct = (2 - 2 * values) <= settings.ratio_to_all**2 * (2 - 2 * others)
    kept = mutual & clear & distinct & (values > settings.likeness)
    return np.stack([rows[kept], best[kept]], axis=1)


def triangulated_pairs(first: FloatArray, second: FloatArray, cameras: Cameras, settings: GuidedSettings) -> FloatArray:
    """Return the points ``[n, 3]`` of pairs of pixels ``[m, 2]``, without those that are uncertain or off.

    The point lies half way between the two rays where they come nearest.
    """
    rays = [
        np.concatenate([pixels, np.ones((len(pixels), 1))], axis=1)
        @ np.linalg.inv(cameras.intrinsics[row]).T
        @ cameras.world_to_camera[row, :3, :3]
        for row, pixels in enumerate((first, second))
    ]
    unit = [ray / np.linalg.norm(ray, axis=1, keepdims=True) for ray in rays]
    between = cameras.centers[1] - cameras.centers[0]
    cosine = (unit[0] * unit[1]).sum(axis=1)
    sine = np.maximum(1 - cosine**2, 1e-12)
    along = [unit[0] @ between, unit[1] @ between]
    near = (along[0] - cosine * along[1]) / sine
    far = (cosine * along[0] - along[1]) / sine
    positions = 0.5 * (cameras.centers[0] + near[:, None] * unit[0] + cameras.centers[1] + far[:, None] * unit[1])
    kept = (near > 0) & (far > 0) & (cosine < np.cos(np.radians(settings.least_angle)))
    for row, pixels in enumerate((first, second)):
        local = positions @ cameras.world_to_camera[row, :3, :3].T + cameras.world_to_camera[row, :3, 3]
        projected = local @ cameras.intrinsics[row].T
        with np.errstate(divide="ignore", invalid="ignore"):
            errors = np.linalg.norm(projected[:, :2] / projected[:, 2:] - pixels, axis=1)
        kept &= (local[:, 2] > 0) & (errors <= settings.error)
    found: FloatArray = positions[kept]
    return found
