"""The photographs that the wheel of scikit-image carries: read from the installed package, never downloaded."""

from __future__ import annotations

import importlib.resources

import numpy as np
import numpy.typing as npt
from PIL import Image

from avs.scene.srgb import from_srgb
from avs.system.errors import UserError

Array = npt.NDArray[np.float32]

# Part of each photograph that is used: left, upper, right, lower in pixels. All are in the public domain or CC0, as the
# documentation of skimage.data says of each.
CROPS: dict[str, tuple[str, tuple[int, int, int, int]]] = {
    "astronaut": ("astronaut.png", (30, 0, 512, 482)),
    "brick": ("brick.png", (0, 192, 512, 512)),
    "cameraman": ("camera.png", (0, 0, 512, 512)),
    "cat": ("chelsea.png", (80, 0, 380, 300)),
    "coffee": ("coffee.png", (60, 0, 460, 400)),
    "coins": ("coins.png", (20, 0, 323, 303)),
    "galaxies": ("hubble_deep_field.jpg", (0, 0, 872, 872)),
    "grass": ("grass.png", (0, 0, 512, 512)),
    "gravel": ("gravel.png", (0, 0, 512, 512)),
    "moon": ("moon.png", (0, 0, 512, 512)),
    "motorcycle": ("motorcycle_left.png", (70, 0, 570, 500)),
    "rocket": ("rocket.jpg", (106, 0, 533, 427)),
    "retina": ("retina.jpg", (200, 200, 1211, 1211)),
    "tissue": ("ihc.png", (0, 0, 512, 512)),
}


def photograph(name: str, size: int) -> Array:
    """Return the photograph ``name`` as ``[size, size, 3]`` linear light in 0..1 (its sRGB encoding undone).

    Raises:
        UserError: the installed scikit-image does not carry the file.
    """
    file, crop = CROPS[name]
    path = importlib.resources.files("skimage") / "data" / file
    if not path.is_file():
        raise UserError(
            path, "photograph is missing", "install scikit-image from its wheel, as environment.txt pins it"
        )
    with path.open("rb") as stream, Image.open(stream) as image:
        pixels = image.convert("RGB").resize((size, size), Image.Resampling.LANCZOS, box=crop, reducing_gap=3.0)
    return from_srgb(np.asarray(pixels, np.float32) / 255)


def grey(name: str, size: int) -> Array:
    """Return the photograph ``name`` as ``[size, size]`` brightness, stretched so that 1 % and 99 % lie at 0 and 1."""
    values = photograph(name, size).mean(axis=2) ** 0.5
    low, high = np.quantile(values, [0.01, 0.99])
    return np.asarray(np.clip((values - low) / (high - low), 0, 1), np.float32)


def tileable(image: Array) -> Array:
    """Return ``image`` ``[size, size, ...]`` changed so that it repeats without a seam.

    The image is blended with itself moved by half its size, under a weight that vanishes at the borders; the blend
    keeps the variance, which a plain average would halve.
    """
    size = len(image)
    ramp = np.clip(1.5 - np.abs(np.linspace(-2, 2, size, dtype=np.float32)), 0, 1)
    weight = np.minimum.outer(ramp, ramp).reshape((size, size) + (1,) * (image.ndim - 2))
    moved = np.roll(image, (size // 2, size // 2), axis=(0, 1))
    mean = image.mean(axis=(0, 1), keepdims=True)
    norm = np.sqrt(weight**2 + (1 - weight) ** 2)
    blend = mean + (weight * (image - mean) + (1 - weight) * (moved - mean)) / norm
    return np.asarray(np.clip(blend, 0, 1), np.float32)
