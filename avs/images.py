"""Image files: reading, writing without loss, and hashing of pixels."""

from __future__ import annotations

import hashlib
import shutil
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from avs.errors import UserError

Pixels = npt.NDArray[np.uint8]


def read_image(path: Path) -> Pixels:
    """Read an image file as ``[height, width, 3]`` uint8 sRGB, as it is stored: its EXIF orientation is not applied.

    Raises:
        UserError: the file is missing, unreadable, truncated, or no image.
    """
    try:
        with Image.open(path) as image:
            if image.mode.startswith(("I", "F")):
                fault = f"the image has more than 8 bits per channel (mode {image.mode})"
                raise UserError(path, fault, "convert it to 8 bits per channel")
            return np.array(image.convert("RGB"))
    except FileNotFoundError as error:
        raise UserError(path, "the model names this image but it is missing", "restore the file") from error
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise
        fault = f"the image is damaged or cut off ({error})"
        raise UserError(path, fault, "copy the image again, or take it out of the model") from error


def pixel_hash(pixels: Pixels) -> str:
    """Return the SHA-256 of an image's shape and bytes, in hexadecimal."""
    digest = hashlib.sha256(repr(pixels.shape).encode())
    digest.update(np.ascontiguousarray(pixels).tobytes())
    return digest.hexdigest()


def store_image(path: Path, image: Pixels | Path) -> Pixels:
    """Write ``image`` to ``path`` and return its pixels."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if isinstance(image, Path):
        pixels = read_image(image)
        shutil.copyfile(image, path)
        return pixels
    if path.suffix != ".png" or image.dtype != np.uint8 or image.ndim != 3:
        raise ValueError(f"{path.name} {image.dtype} {image.shape}: uint8 pixels are stored without loss, as .png")
    Image.fromarray(image).save(path, format="PNG", compress_level=6)
    return image
