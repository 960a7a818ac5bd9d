"""Depth and normal maps of views by stereo: plane sweep, semi-global matching, PatchMatch."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image

from avs.scene.cameras import Cameras, FloatArray, IndexArray
from avs.sfm.chess_board import NOWHERE, columns_apart, halves, whole
from avs.sfm.patch_match import IMPOSSIBLE, RADIUS, STEEPEST, TRIALS, visit
from avs.sfm.plane_sweep import sweep
from avs.sfm.semi_global import smoothed, winners
from avs.sfm.sfm_settings import StereoSettings
from avs.sfm.stereo_vectors import BORDER, packed

Grey = npt.NDArray[np.uint8]
FloatMap = npt.NDArray[np.float32]

_SMALLEST = 12
"""Pixels of a side, at least: windows of 7 x 7 need some room."""


@dataclass(frozen=True)
class DepthMap:
    """What stereo says of one view.

    Attributes:
        planes: ``[h, w, 3]`` float32: inverse depth along the optical axis, and its change by one column and by one row
            on the plane that the surface is there.
        cost: ``[h, w]`` float32: one less the mean correlation with the best two sources, and what their own depths
            say against it.
    """

    planes: FloatMap
    cost: FloatMap

    @property
    def depth(self) -> FloatMap:
        """Depth along the optical axis, ``[h, w]`` float32, in scene units."""
        depth: FloatMap = np.float32(1) / self.planes[..., 0]
        return depth


@dataclass(frozen=True)
class Picture:
    """A picture to be compared with others.

    Attributes:
        grey: ``[h, w]``.
        packed: the same for kernels, see ``stereo_vectors.packed``.
    """

    grey: Grey
    packed: npt.NDArray[np.int32]


@dataclass(frozen=True)
class Stereo:
    """A view and its sources, to be compared.

    Attributes:
        pictures: of the view and of its sources, at least one.
        small: likewise, for the sweep.
        cameras: likewise.
        limits: least and greatest inverse depth of the view.
    """

    pictures: list[Picture]
    small: list[Picture]
    cameras: Cameras
    limits: tuple[float, float]


def grey_of(image: npt.NDArray[np.uint8]) -> Grey:
    """Return the luma ``[h, w]`` of a colour image."""
    return np.asarray(Image.fromarray(image).convert("L"))


def picture_of(grey: Grey) -> Picture:
    """Return a picture ``[h, w]`` to be compared."""
    return Picture(grey, packed(grey))


def small_picture_of(picture: Picture, side: int) -> Picture:
    """Return a picture reduced by a whole number, so that its long side is about ``side`` pixels."""
    factor = max(1, round(max(picture.grey.shape) / side))
    return picture if factor == 1 else picture_of(_reduced(picture.grey, factor))


def depth_map(stereo: Stereo, settings: StereoSettings, seed: int) -> DepthMap:
    """Return the depth map of a view by what its picture and those of its sources show."""
    planes = np.linspace(*stereo.limits, settings.planes).astype(np.float32)
    start = _slanted(_swept(stereo, planes), stereo.pictures[0].grey.shape)
    return refined(stereo, start, float(planes[1] - planes[0]), settings.iterations, settings.active, seed)


def refined(
    stereo: Stereo,
    start: FloatMap,
    step: float,
    iterations: int,
    few: int,
    seed: int,
    depths: list[FloatMap] | None = None,
) -> DepthMap:
    """Return the depth map of a view by PatchMatch.

    Args:
        stereo: the view and its sources.
        start: ``[h, w, 3]``, see ``DepthMap.planes``.
        step: greatest random change of an inverse depth in the first iteration; it halves with each.
        iterations: how often every pixel is visited.
        few: sources in which a new plane is compared.
        seed: of the random changes.
        depths: inverse depths of the sources, which the view's should agree with, of ``bordered``; or None.
    """
    width = start.shape[1]
    tilt = 1 / float(stereo.cameras.intrinsics[0, (0, 1), (0, 1)].mean())
    steepest = STEEPEST * tilt * start[..., 0]
    slopes = [np.clip(start[..., k], -steepest, steepest) for k in (1, 2)]
    planes = [halves(start[..., 0], NOWHERE), *(halves(slope, 0.0) for slope in slopes)]
    state = np.stack([*planes, np.full_like(planes[0], IMPOSSIBLE)])
    sources, shapes = _joined(stereo.pictures[1:])
    known = np.concatenate(depths) if depths else np.zeros(0, dtype=np.float32)
    apart = columns_apart(stereo.pictures[0].grey, RADIUS).reshape(-1)
    maps = _maps(stereo.cameras).reshape(-1)
    for number in range(iterations):
        noise = _noise(seed, number, (3 * TRIALS, 2, state.shape[2] - 2, state.shape[3]))
        change = step * 0.5**number, 2 * tilt * 0.6**number
        bounds = (0.8 * stereo.limits[0], 1.25 * stereo.limits[1], *change, STEEPEST * tilt)
        search = np.array(bounds, dtype=np.float32)
        visit(apart, sources, known, shapes.reshape(-1), maps, noise, state, search, width, few)
    parts = [whole(part, width) for part in state]
    return DepthMap(np.stack(parts[:3], axis=-1), parts[3])


@functools.lru_cache(maxsize=4)
def _noise(seed: int, number: int, shape: tuple[int, ...]) -> FloatMap:
    """Return random numbers in -1..1, the same for all views."""
    noise = 2 * np.random.Generator(np.random.SFC64([seed, number])).random(shape, dtype=np.float32) - 1
    noise.flags.writeable = False
    return noise


def _swept(stereo: Stereo, planes: FloatMap) -> FloatMap:
    """Return the inverse depths ``[h, w]`` of the small picture of a view by plane sweep and semi-global matching."""
    grey = stereo.small[0].grey
    height, width = grey.shape
    sizes = np.array([picture.grey.shape[::-1] for picture in stereo.small], dtype=np.int64)
    sources, shapes = _joined(stereo.small[1:])
    costs = sweep(grey, sources, shapes, _maps(stereo.cameras.resized(sizes)), planes, height, width)
    volume = np.ascontiguousarray(costs[:, :, :width].transpose(1, 2, 0))
    place = winners(smoothed(volume, grey))
    inverse: FloatMap = (planes[0] + place * (planes[1] - planes[0])).astype(np.float32)
    return inverse


def _slanted(inverse: FloatMap, shape: tuple[int, ...]) -> FloatMap:
    """Return the planes ``[h, w, 3]`` of a larger picture through the inverse depths of a smaller one."""
    import cv2  # here, as it takes long to import

    inverse = np.asarray(cv2.medianBlur(inverse, 3), dtype=np.float32)
    change, mean = np.arange(-2, 3) / 10, np.ones(5) / 5
    slopes = [
        cv2.sepFilter2D(inverse, cv2.CV_32F, across, down, borderType=cv2.BORDER_REPLICATE)
        for across, down in ((change, mean), (mean, change))
    ]
    rows = (np.arange(shape[0]) + 0.5) * inverse.shape[0] / shape[0]
    columns = (np.arange(shape[1]) + 0.5) * inverse.shape[1] / shape[1]
    at = np.ix_(rows.astype(np.int64), columns.astype(np.int64))
    by_row, by_column = inverse.shape[0] / shape[0], inverse.shape[1] / shape[1]
    beside, below = (rows % 1 - 0.5)[:, None], (columns % 1 - 0.5)[None]
    place = inverse[at] + slopes[1][at] * beside + slopes[0][at] * below
    place = np.clip(place, inverse.min(), inverse.max())
    return np.stack([place, slopes[0][at] * by_column, slopes[1][at] * by_row], axis=-1).astype(np.float32)


def normals_of(planes: FloatMap, camera: Cameras) -> FloatMap:
    """Return the unit normals ``[h, w, 3]`` of planes, in the axes of the camera, towards it.

    On a plane ``m . X = 1`` the inverse depth at a pixel is m times the pixel's ray, so that its changes tell m.
    """
    height, width = planes.shape[:2]
    matrix = camera.intrinsics[0]
    columns, rows = np.arange(width) + 0.5, (np.arange(height) + 0.5)[:, None]
    third = planes[..., 0] - planes[..., 1] * (columns - matrix[0, 2]) - planes[..., 2] * (rows - matrix[1, 2])
    vectors = -np.stack([planes[..., 1] * matrix[0, 0], planes[..., 2] * matrix[1, 1], third], axis=-1)
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


def _joined(pictures: list[Picture]) -> tuple[npt.NDArray[np.int32], IndexArray]:
    """Return packed pictures one after another, and where each begins, its height and its width with the border."""
    sides = np.array([picture.grey.shape for picture in pictures], dtype=np.int64) + 2 * BORDER
    starts = np.concatenate([[0], np.cumsum(sides.prod(axis=1))[:-1]])
    return np.concatenate([picture.packed for picture in pictures]), np.column_stack([starts, sides])


def _reduced(picture: Grey, factor: int) -> Grey:
    """Return the means of squares of ``factor`` pixels."""
    height, width = (max(_SMALLEST, side // factor) for side in picture.shape)
    return np.asarray(Image.fromarray(picture).resize((width, height), Image.Resampling.BOX))
