"""Photographs of a lit scene: samples within pixels, exposure, tone curve, vignette; and exact depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.cameras import Cameras
from avs.datasets.embedded.model import Array
from avs.datasets.embedded.photographs import to_srgb
from avs.datasets.embedded.shading import Shader


@dataclass(frozen=True)
class Lens:
    """Camera of a capture pattern.

    Attributes:
        aspect: width over height.
        field_of_view: angle along the long side in degrees.
        exposure: factor on the exposure that suits the scene.
        exposure_jitter: standard deviation of each image's exposure, in stops.
        vignette: share of light lost in the corners.
    """

    aspect: float
    field_of_view: float
    exposure: float = 1.0
    exposure_jitter: float = 0.0
    vignette: float = 0.0

    def size(self, long_side: int) -> tuple[int, int]:
        """Return width and height in pixels."""
        short = max(1, round(long_side / max(self.aspect, 1 / self.aspect)))
        return (long_side, short) if self.aspect >= 1 else (short, long_side)

    def cameras(self, world_to_camera: npt.NDArray[np.float64], long_side: int) -> Cameras:
        """Return cameras at the poses ``[n, 4, 4]``, with square pixels and the principal point in the middle."""
        width, height = self.size(long_side)
        focal = long_side / 2 / np.tan(np.radians(self.field_of_view) / 2)
        intrinsics = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
        count = len(world_to_camera)
        return Cameras(
            world_to_camera, np.tile(intrinsics, (count, 1, 1)), np.tile(np.array([[width, height]]), (count, 1))
        )


def pixel_rays(cameras: Cameras, index: int, pixels: npt.NDArray[np.floating]) -> tuple[Array, Array]:
    """Return the centre ``[3]`` of camera ``index`` and directions ``[n, 3]`` of depth one through ``pixels`` ``[n, 2]``."""
    matrix, pose = cameras.intrinsics[index], cameras.world_to_camera[index]
    plane = (pixels - matrix[:2, 2]) / matrix[[0, 1], [0, 1]]
    local = np.concatenate([plane, np.ones((len(plane), 1))], axis=1)
    return cameras.centers[index].astype(np.float32), (local @ pose[:3, :3]).astype(np.float32)


def render(shader: Shader, cameras: Cameras, index: int, samples_per_axis: int, rng: np.random.Generator) -> Array:
    """Return the linear image ``[height, width, 3]`` of camera ``index``, the mean of stratified samples per pixel."""
    width, height = (int(value) for value in cameras.sizes[index])
    side = samples_per_axis
    count = height * width * side * side
    strata = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), -1).reshape(1, 1, -1, 2)
    corner = np.stack(np.meshgrid(np.arange(height), np.arange(width), indexing="ij"), -1)[:, :, None]
    inside = (strata + rng.random((height, width, side * side, 2))) / side
    pixels = (corner + inside).reshape(count, 2)[:, ::-1]
    center, directions = pixel_rays(cameras, index, pixels)
    length = np.linalg.norm(directions, axis=1, keepdims=True)
    footprint = 1 / (float(cameras.intrinsics[index, 0, 0]) * side)
    draws = _sequence(height * width, side * side, rng)
    radiance, _ = shader.radiance(np.broadcast_to(center, directions.shape), directions / length, footprint, draws)
    return radiance.reshape(height, width, side * side, 3).mean(axis=2)


def _sequence(pixels: int, samples: int, rng: np.random.Generator) -> Array:
    """Return ``[pixels * samples, 3]`` numbers in 0..1: the R3 sequence in each pixel, shifted by chance (Roberts 2018).

    Its points are spread evenly, so that a penumbra is smooth with few samples.
    """
    root = 1.2207440846057596
    steps = np.array([1 / root, 1 / root**2, 1 / root**3]) * np.arange(samples)[:, None]
    return np.asarray(((rng.random((pixels, 1, 3)) + steps) % 1).reshape(-1, 3), np.float32)


def depth(shader: Shader, cameras: Cameras, index: int) -> Array:
    """Return the depth ``[height, width]`` along the optical axis at the pixel centres; 0 where there is no surface."""
    width, height = (int(value) for value in cameras.sizes[index])
    pixels = (
        np.stack(np.meshgrid(np.arange(height), np.arange(width), indexing="ij"), -1)[..., ::-1].reshape(-1, 2) + 0.5
    )
    center, directions = pixel_rays(cameras, index, pixels)
    distance = shader.caster.nearest(np.broadcast_to(center, directions.shape), directions).distance
    return np.where(np.isfinite(distance), distance, 0).reshape(height, width).astype(np.float32)


def develop(images: list[Array], lens: Lens, rng: np.random.Generator) -> tuple[npt.NDArray[np.uint8], ...]:
    """Return sRGB photographs of linear ``images``: one exposure for all, jitter, vignette, and a filmic tone curve."""
    logs = np.concatenate([np.log(image.mean(axis=2).ravel()[::7] + 1e-3) for image in images])
    exposure = 0.2 * lens.exposure / np.exp(logs.mean())
    result = []
    for image in images:
        stops = lens.exposure_jitter * rng.normal()
        light = image * exposure * 2.0**stops * _vignette(image.shape[0], image.shape[1], lens.vignette)[..., None]
        coded = to_srgb(_filmic(light)) * 255
        result.append(np.clip(np.rint(coded), 0, 255).astype(np.uint8))
    return tuple(result)


def _vignette(height: int, width: int, loss: float) -> Array:
    y, x = np.meshgrid(np.linspace(-1, 1, height), np.linspace(-1, 1, width), indexing="ij")
    return (1 - loss * np.clip((x * x + y * y) / 2, 0, 1) ** 1.5).astype(np.float32)


def _filmic(light: Array) -> Array:
    """Compress 0..infinity to 0..1: a soft shoulder as film has it, and a slight toe."""
    return np.asarray((1 - np.exp(-1.25 * light)) ** 1.15, np.float32)
