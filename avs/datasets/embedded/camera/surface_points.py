"""Sparse points as structure from motion would leave them: at textured, visible places, a little off."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.camera.render import pixel_rays
from avs.datasets.embedded.embedded_settings import EmbeddedSettings
from avs.datasets.embedded.geometry.mesh_model import Array
from avs.datasets.embedded.geometry.raycast import Caster
from avs.scene.cameras import Cameras, IndexArray
from avs.scene.scene import Points

Images = tuple[npt.NDArray[np.uint8], ...]

# Features are matched over viewing directions up to this far apart (radians); SIFT loses most matches beyond about 40
# degrees (Mikolajczyk and Schmid 2005).
_MATCH_ANGLE = 0.7
_MIN_VIEWS = 3


def sparse_points(
    caster: Caster,
    cameras: Cameras,
    images: Images,
    depths: tuple[Array, ...],
    pool: IndexArray,
    settings: EmbeddedSettings,
    rng: np.random.Generator,
) -> Points:
    """Return at most ``settings.points`` points, each seen without occlusion by at least three images of the pool.

    Candidates are pixels drawn with a probability that grows with the local contrast. A candidate counts as observed
    where it projects into an image, nothing lies before it, and the direction differs by less than a matcher bears.
    Test images have no part in where a point lies, whether it is there and what colour it has.

    Args:
        caster: of the scene.
        cameras: of all images.
        images: all photographs.
        depths: ``[height, width]`` of each.
        pool: indices of the images that are no test images.
        settings: number of points, and their error.
        rng: source of all that is random.
    """
    cameras, images = cameras[pool], tuple(images[index] for index in pool)
    depths = tuple(depths[index] for index in pool)
    wanted = 3 * settings.points // len(cameras) + 1
    positions, origins = [], []
    for index, (image, depth) in enumerate(zip(images, depths, strict=True)):
        pixels = _corners(image, depth, wanted, rng)
        center, directions = pixel_rays(cameras, index, pixels + 0.5)
        along = depth[pixels[:, 1], pixels[:, 0]]
        positions.append(center + directions * along[:, None])
        origins.append(np.full(len(pixels), index))
    spots, source = np.concatenate(positions), np.concatenate(origins)
    seen = _visibility(caster, cameras, spots, source)
    seen &= rng.random(seen.shape) < 0.85
    seen[np.arange(len(spots)), source] = True
    kept = np.flatnonzero(seen.sum(axis=1) >= _MIN_VIEWS)
    kept = np.sort(rng.permutation(kept)[: settings.points])
    spots, seen = spots[kept], seen[kept]
    near = np.linalg.norm(spots[:, None] - cameras.centers[None], axis=2)
    spacing = near.min(axis=1, where=seen, initial=np.inf) / float(cameras.intrinsics[0, 0, 0])
    noisy = spots + rng.normal(size=spots.shape) * (settings.point_noise * spacing)[:, None]
    rows, views = np.nonzero(seen)
    observations = np.stack([rows, pool[views]], axis=1)
    return Points(noisy.astype(np.float64), _colors(cameras, images, spots, seen), observations)


def _corners(image: npt.NDArray[np.uint8], depth: Array, count: int, rng: np.random.Generator) -> npt.NDArray[np.int64]:
    """Return up to ``count`` pixels ``[n, 2]`` (x, y) of surfaces, preferring high contrast in both directions."""
    grey = image.mean(axis=2)
    down, right = np.gradient(grey)
    contrast = np.minimum(np.hypot(down, right), 60.0)
    weight = np.where(depth > 0, np.maximum(contrast - 3.0, 0), 0).ravel()
    available = int((weight > 0).sum())
    if not available:
        return np.zeros((0, 2), np.int64)
    chosen = rng.choice(weight.size, size=min(count, available), replace=False, p=weight / weight.sum())
    return np.stack([chosen % image.shape[1], chosen // image.shape[1]], axis=1)


def project(
    cameras: Cameras, index: int, spots: npt.NDArray[np.floating]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return pixel positions ``[n, 2]`` and depths ``[n]`` of world points ``[n, 3]`` in camera ``index``."""
    pose, matrix = cameras.world_to_camera[index], cameras.intrinsics[index]
    local = spots @ pose[:3, :3].T + pose[:3, 3]
    ahead = np.maximum(local[:, 2:], 1e-6)
    return local[:, :2] / ahead * matrix[[0, 1], [0, 1]] + matrix[:2, 2], local[:, 2]


def inside(
    cameras: Cameras, index: int, pixels: npt.NDArray[np.floating], depth: npt.NDArray[np.floating]
) -> npt.NDArray[np.bool_]:
    """Return which of the ``pixels`` ``[n, 2]`` at ``depth`` ``[n]`` lie in the image of camera ``index``."""
    return np.asarray((depth > 0.05) & (pixels >= 0).all(axis=1) & (pixels < cameras.sizes[index]).all(axis=1))


def _visibility(caster: Caster, cameras: Cameras, spots: Array, source: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Return ``[points, images]``: which image sees which point under a direction close enough to be matched."""
    centers = cameras.centers
    toward = centers[source] - spots
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    seen = np.zeros((len(spots), len(cameras)), bool)
    for index in range(len(cameras)):
        pixels, depth = project(cameras, index, spots)
        way = centers[index] - spots
        angle = np.einsum("ij,ij->i", way, toward) / np.maximum(np.linalg.norm(way, axis=1), 1e-9)
        chosen = np.flatnonzero(inside(cameras, index, pixels, depth) & (angle > np.cos(_MATCH_ANGLE)))
        if len(chosen):
            # From the camera to just before the point: a start on the surface would meet the surface itself.
            blocked = caster.blocked(
                np.broadcast_to(centers[index].astype(np.float32), (len(chosen), 3)), -way[chosen], 0.995
            )
            seen[chosen[~blocked], index] = True
    return seen


def _colors(cameras: Cameras, images: Images, spots: Array, seen: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint8]:
    """Return the mean colour ``[n, 3]`` of each point over the images that see it."""
    total = np.zeros((len(spots), 3))
    for index, image in enumerate(images):
        rows = np.flatnonzero(seen[:, index])
        pixels = np.floor(project(cameras, index, spots[rows])[0]).astype(np.int64)
        x, y = np.clip(pixels[:, 0], 0, image.shape[1] - 1), np.clip(pixels[:, 1], 0, image.shape[0] - 1)
        total[rows] += image[y, x]
    return np.asarray(np.rint(total / np.maximum(seen.sum(axis=1), 1)[:, None]), np.uint8)
