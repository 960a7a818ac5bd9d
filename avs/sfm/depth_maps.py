"""Depth and normal maps of views by stereo: plane sweep, semi-global matching, PatchMatch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image
from scipy import ndimage

from avs.scene.cameras import Cameras, FloatArray, IndexArray
from avs.sfm.patch_match import IMPOSSIBLE, NOWHERE, STEEPEST, TRIALS, columns_apart, halves, visit, whole
from avs.sfm.plane_sweep import sweep
from avs.sfm.semi_global import smoothed, winners
from avs.sfm.sfm_settings import StereoSettings
from avs.sfm.stereo_vectors import packed

Grey = npt.NDArray[np.uint8]
FloatMap = npt.NDArray[np.float32]

OFFSETS = np.array([[x, y] for y in range(-2, 3) for x in range(-2, 3)], dtype=np.int64)
"""Columns and rows of the pixels of a window of PatchMatch, from its middle."""

_SMALLEST = 12
"""Pixels of a side, at least: windows of 7 x 7 need some room."""


@dataclass(frozen=True)
class DepthMap:
    """What stereo says of one view.

    Attributes:
        depth: ``[h, w]`` float32, along the optical axis.
        normals: ``[h, w, 3]`` float32, of unit length, in the camera's axes, towards the camera.
        cost: ``[h, w]`` float32 in 0..2: one less the mean correlation with the best two sources.
    """

    depth: FloatMap
    normals: FloatMap
    cost: FloatMap


def grey_of(image: npt.NDArray[np.uint8]) -> Grey:
    """Return the luma ``[h, w]`` of a colour image."""
    return np.asarray(Image.fromarray(image).convert("L"))


def depth_map(
    pictures: list[Grey], cameras: Cameras, limits: tuple[float, float], settings: StereoSettings, seed: int
) -> DepthMap:
    """Return the depth map of the first of some views.

    Args:
        pictures: of the view and of its sources, at least one.
        cameras: likewise.
        limits: least and greatest inverse depth.
        settings: see there.
        seed: of PatchMatch.
    """
    planes = np.linspace(*limits, settings.planes).astype(np.float32)
    factor = max(1, round(max(pictures[0].shape) / settings.sweep_side))
    small = [_reduced(picture, factor) for picture in pictures]
    sizes = np.array([picture.shape[::-1] for picture in small], dtype=np.int64)
    inverse = _swept(small, cameras.resized(sizes), planes)
    state = _slanted(inverse, pictures[0].shape)
    state = refined(pictures, cameras, state, (limits[0], limits[1], float(planes[1] - planes[0])), settings, seed)
    depth: FloatMap = np.float32(1) / state[..., 0]
    return DepthMap(depth, _normals(state, cameras), state[..., 3])


def refined(
    pictures: list[Grey],
    cameras: Cameras,
    state: FloatMap,
    search: tuple[float, float, float],
    settings: StereoSettings,
    seed: int,
) -> FloatMap:
    """Return the planes of the first picture, and their costs, after PatchMatch, ``[h, w, 4]``.

    Args:
        pictures: of the view and of its sources.
        cameras: likewise.
        state: ``[h, w, 3]``: inverse depth, its change by one column, and by one row.
        search: least and greatest inverse depth, and the greatest change to begin with.
        settings: see there.
        seed: of the random changes.
    """
    width = state.shape[1]
    tilt = 1 / float(cameras.intrinsics[0, (0, 1), (0, 1)].mean())
    steepest = STEEPEST * tilt * state[..., 0]
    slopes = [np.clip(state[..., k], -steepest, steepest) for k in (1, 2)]
    planes = [halves(state[..., 0], NOWHERE), *(halves(slope, 0.0) for slope in slopes)]
    sorted_ = np.stack([*planes, np.full_like(planes[0], IMPOSSIBLE)])
    sources, shapes = _joined(pictures[1:])
    apart = columns_apart(pictures[0], int(np.abs(OFFSETS).max())).reshape(-1)
    rng = np.random.Generator(np.random.SFC64(seed))
    for step in range(settings.iterations):
        shape = (3 * TRIALS, 2, sorted_.shape[2] - 2, sorted_.shape[3])
        noise = 2 * rng.random(shape, dtype=np.float32) - 1
        change = search[2] * 0.5**step, 2 * tilt * 0.6**step
        bounds = np.array([0.8 * search[0], 1.25 * search[1], *change, STEEPEST * tilt], dtype=np.float32)
        maps = _maps(cameras).reshape(-1)
        visit(apart, sources, shapes.reshape(-1), maps, OFFSETS, noise, sorted_, bounds, width, step == 0)
    return np.stack([whole(part, width) for part in sorted_], axis=-1)


def _swept(pictures: list[Grey], cameras: Cameras, planes: FloatMap) -> FloatMap:
    """Return the inverse depths ``[h, w]`` of the first picture by plane sweep and semi-global matching."""
    height, width = pictures[0].shape
    sources, shapes = _joined(pictures[1:])
    costs = sweep(packed(pictures[0]), sources, shapes, _maps(cameras), planes, height, width)
    volume = np.ascontiguousarray(costs[:, :, :width].transpose(1, 2, 0))
    place = winners(smoothed(volume, pictures[0]))
    inverse: FloatMap = (planes[0] + place * (planes[1] - planes[0])).astype(np.float32)
    return inverse


def _slanted(inverse: FloatMap, shape: tuple[int, ...]) -> FloatMap:
    """Return the planes ``[h, w, 3]`` of a larger picture through the inverse depths of a smaller one."""
    inverse = ndimage.median_filter(inverse, size=3, mode="nearest")
    across, down = np.arange(-2, 3) / 10, np.ones(5) / 5
    slopes = [
        ndimage.correlate1d(ndimage.correlate1d(inverse, one, axis=1, mode="nearest"), other, axis=0, mode="nearest")
        for one, other in ((across, down), (down, across))
    ]
    rows = (np.arange(shape[0]) + 0.5) * inverse.shape[0] / shape[0]
    columns = (np.arange(shape[1]) + 0.5) * inverse.shape[1] / shape[1]
    at = np.ix_(rows.astype(np.int64), columns.astype(np.int64))
    by_row, by_column = inverse.shape[0] / shape[0], inverse.shape[1] / shape[1]
    beside, below = (rows % 1 - 0.5)[:, None], (columns % 1 - 0.5)[None]
    place = inverse[at] + slopes[1][at] * beside + slopes[0][at] * below
    place = np.clip(place, inverse.min(), inverse.max())
    return np.stack([place, slopes[0][at] * by_column, slopes[1][at] * by_row], axis=-1).astype(np.float32)


def _normals(state: FloatMap, cameras: Cameras) -> FloatMap:
    """Return the unit normals ``[h, w, 3]`` of planes, towards the camera, the first of ``cameras``.

    On a plane ``m . X = 1`` the inverse depth at a pixel is m times the pixel's ray, so that its changes tell m.
    """
    height, width = state.shape[:2]
    matrix = cameras.intrinsics[0]
    columns, rows = np.arange(width) + 0.5, (np.arange(height) + 0.5)[:, None]
    third = state[..., 0] - state[..., 1] * (columns - matrix[0, 2]) - state[..., 2] * (rows - matrix[1, 2])
    vectors = -np.stack([state[..., 1] * matrix[0, 0], state[..., 2] * matrix[1, 1], third], axis=-1)
    normals: FloatMap = (vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)).astype(np.float32)
    return normals


def _maps(cameras: Cameras) -> FloatMap:
    """Return the maps ``[s, 12]`` from pixels of the first camera to those of the others, see ``plane_sweep.sweep``."""
    intrinsics = cameras.intrinsics.copy()
    intrinsics[:, :2, 2] -= 0.5
    relative = cameras.world_to_camera[1:] @ np.linalg.inv(cameras.world_to_camera[0])
    matrices = intrinsics[1:] @ relative[:, :3, :3] @ np.linalg.inv(intrinsics[0])
    vectors = np.einsum("sij,sj->si", intrinsics[1:], relative[:, :3, 3])
    maps: FloatArray = np.concatenate([matrices.reshape(-1, 9), vectors], axis=1)
    return maps.astype(np.float32)


def _joined(pictures: list[Grey]) -> tuple[npt.NDArray[np.int32], IndexArray]:
    """Return packed pictures one after another, and where each begins, its height and its width."""
    sizes = [picture.size for picture in pictures]
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    shapes = [(start, *picture.shape) for start, picture in zip(starts, pictures, strict=True)]
    return np.concatenate([packed(picture) for picture in pictures]), np.array(shapes, dtype=np.int64)


def _reduced(picture: Grey, factor: int) -> Grey:
    """Return the means of squares of ``factor`` pixels."""
    if factor == 1:
        return picture
    height, width = (max(_SMALLEST, side // factor) for side in picture.shape)
    return np.asarray(Image.fromarray(picture).resize((width, height), Image.Resampling.BOX))
