"""The pixels of all captured photographs, from which each step of an optimisation draws some."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from avs.representations.ray_fields.camera_rays import Rays, pixel_rays
from avs.scene.cameras import Cameras, IndexArray
from avs.scene.views import Views


@dataclass(frozen=True)
class Batch:
    """Pixels of one step.

    Attributes:
        rays: n rays.
        colors: ``[n, 3]`` float32 in 0..1, what the photographs show.
        photographs: ``[n]`` int64, which photograph each is of, in order of capture.
    """

    rays: Rays
    colors: Tensor
    photographs: Tensor


@dataclass(frozen=True)
class PixelPool:
    """The pixels of photographs, one photograph behind another.

    Attributes:
        names: of the photographs.
        cameras: of the photographs.
        starts: ``[photographs + 1]``, where each one's pixels start, and the number of all.
        colors: ``[pixels, 3]`` uint8.
    """

    names: tuple[str, ...]
    cameras: Cameras
    starts: IndexArray
    colors: npt.NDArray[np.uint8]


def pixel_pool(views: Views) -> PixelPool:
    """Return the pixels of ``views``."""
    sizes = [image.shape[0] * image.shape[1] for image in views.images]
    colors = np.concatenate([image.reshape(-1, 3) for image in views.images])
    return PixelPool(views.names, views.cameras, np.cumsum([0, *sizes]), colors)


def drawn_pixels(pool: PixelPool, generator: np.random.Generator, count: int, device: torch.device) -> Batch:
    """Return ``count`` pixels, each as likely as any other, with repetition: a new photograph has its share at once."""
    pixels = generator.integers(pool.starts[-1], size=count)
    rows = np.searchsorted(pool.starts, pixels, side="right") - 1
    y, x = np.divmod(pixels - pool.starts[rows], pool.cameras.sizes[rows, 0])
    colors = pool.colors[pixels].astype(np.float32) / np.float32(255)
    return Batch(
        pixel_rays(pool.cameras, rows, x, y, device),
        torch.from_numpy(colors).to(device),
        torch.from_numpy(rows).to(device),
    )
