"""Light and depth at the pixels of cameras."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.camera.film import WHITE, exposure_of
from avs.datasets.embedded.geometry.mesh_model import Array
from avs.datasets.embedded.light.shading import Shader
from avs.scene.cameras import Cameras


def pixel_rays(cameras: Cameras, index: int, pixels: npt.NDArray[np.floating]) -> tuple[Array, Array]:
    """Return the centre ``[3]`` of a camera and directions ``[n, 3]`` of depth one through ``pixels`` ``[n, 2]``."""
    matrix, pose = cameras.intrinsics[index], cameras.world_to_camera[index]
    plane = (pixels - matrix[:2, 2]) / matrix[[0, 1], [0, 1]]
    local = np.concatenate([plane, np.ones((len(plane), 1))], axis=1)
    return cameras.centers[index].astype(np.float32), (local @ pose[:3, :3]).astype(np.float32)


def meter(shader: Shader, cameras: Cameras, rng: np.random.Generator) -> float:
    """Return the exposure that suits all ``cameras``, from images of 24 pixels on the long side."""
    small = cameras.resized(np.maximum(np.rint(cameras.sizes * 24 / cameras.sizes.max()), 1).astype(np.int64))
    images = [render(shader, small, index, 1, np.inf, rng).reshape(-1, 3) for index in range(0, len(small), 2)]
    return exposure_of(np.concatenate(images))


def render(
    shader: Shader, cameras: Cameras, index: int, samples_per_axis: int, exposure: float, rng: np.random.Generator
) -> Array:
    """Return the linear image ``[height, width, 3]`` of camera ``index``, the mean of stratified samples per pixel.

    Samples that are white at ``exposure`` are clipped.
    """
    width, height = (int(value) for value in cameras.sizes[index])
    side = samples_per_axis
    count = height * width * side * side
    strata = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), -1).reshape(1, 1, -1, 2)
    corner = np.stack(np.meshgrid(np.arange(height), np.arange(width), indexing="ij"), -1)[:, :, None]
    inside = (strata + rng.random((height, width, side * side, 2), dtype=np.float32)) / side
    pixels = (corner + inside).reshape(count, 2)[:, ::-1]
    center, directions = pixel_rays(cameras, index, pixels)
    length = np.linalg.norm(directions, axis=1, keepdims=True)
    footprint = 1 / (float(cameras.intrinsics[index, 0, 0]) * side)
    draws = _sequence(height * width, side * side, rng)
    radiance = shader.radiance(np.broadcast_to(center, directions.shape), directions / length, footprint, draws)
    if np.isfinite(exposure):
        radiance = np.minimum(radiance, WHITE / exposure)
    return np.asarray(radiance.reshape(height, width, side * side, 3).mean(axis=2))


def _sequence(pixels: int, samples: int, rng: np.random.Generator) -> Array:
    """Return ``[pixels * samples, 3]`` numbers in 0..1: per pixel the R3 sequence (Roberts 2018), shifted by chance.

    Its points are spread evenly, so that a penumbra is smooth with few samples.
    """
    root = 1.2207440846057596
    steps = np.array([1 / root, 1 / root**2, 1 / root**3]) * np.arange(samples)[:, None]
    return np.asarray(((rng.random((pixels, 1, 3), dtype=np.float32) + steps) % 1).reshape(-1, 3), np.float32)


def depth(shader: Shader, cameras: Cameras, index: int) -> Array:
    """Return the depth ``[height, width]`` along the optical axis at the pixel centres; 0 where there is no surface."""
    width, height = (int(value) for value in cameras.sizes[index])
    pixels = (
        np.stack(np.meshgrid(np.arange(height), np.arange(width), indexing="ij"), -1)[..., ::-1].reshape(-1, 2) + 0.5
    )
    center, directions = pixel_rays(cameras, index, pixels)
    distance = shader.caster.nearest(np.broadcast_to(center, directions.shape), directions).distance
    return np.where(np.isfinite(distance), distance, 0).reshape(height, width).astype(np.float32)
