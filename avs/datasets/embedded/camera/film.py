"""From light to photographs: exposure, film curve, vignette."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.camera.lens import Lens
from avs.datasets.embedded.geometry.mesh_model import Array
from avs.scene.srgb import to_srgb

WHITE = 2.2
"""Exposed light beyond which samples are clipped: the curve is flat there, and edges against it would be jagged."""


def exposure_of(light: npt.NDArray[np.floating]) -> float:
    """Return the factor that puts the geometric mean of ``light`` ``[..., 3]`` at a fifth of white."""
    return float(0.2 / np.exp(np.log(light.mean(axis=-1) + 1e-3).mean()))


def tone(light: Array, exposure: float) -> npt.NDArray[np.uint8]:
    """Return ``light`` ``[..., 3]`` as sRGB, with a soft shoulder as film has it, and a slight toe."""
    linear = (1 - np.exp(-1.25 * exposure * light)) ** 1.15
    return np.clip(np.rint(to_srgb(linear) * 255), 0, 255).astype(np.uint8)


def develop(
    images: list[Array], exposure: float, lens: Lens, rng: np.random.Generator
) -> tuple[npt.NDArray[np.uint8], ...]:
    """Return sRGB photographs of linear ``images``, each with its own jitter of the exposure, and the vignette."""
    result = []
    for image in images:
        stops = lens.exposure_jitter * rng.normal()
        light = image * _vignette(image.shape[0], image.shape[1], lens.vignette)[..., None]
        result.append(tone(light, exposure * lens.exposure * 2.0**stops))
    return tuple(result)


def _vignette(height: int, width: int, loss: float) -> Array:
    y, x = np.meshgrid(np.linspace(-1, 1, height), np.linspace(-1, 1, width), indexing="ij")
    return (1 - loss * np.clip((x * x + y * y) / 2, 0, 1) ** 1.5).astype(np.float32)
