"""Image files: reading, writing without loss, and hashing of pixels."""

from __future__ import annotations

import contextlib
import hashlib
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageOps

from avs.system.errors import UserError

Pixels = npt.NDArray[np.uint8]


@contextlib.contextmanager
def open_image(path: Path) -> Iterator[Image.Image]:
    """Open an image file; its pixels are decoded when they are asked for, inside the block.

    Raises:
        UserError: the file is missing, truncated, no image, or has more than 8 bits per channel.
    """
    try:
        with Image.open(path) as image:
            if image.mode.startswith(("I", "F")):
                fault = f"the image has more than 8 bits per channel (mode {image.mode})"
                raise UserError(path, fault, "convert it to 8 bits per channel")
            yield image
    except FileNotFoundError as error:
        raise UserError(path, "the image is missing, but the model names it", "restore the file") from error
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise
        fault = f"the image is damaged or cut off ({error})"
        raise UserError(path, fault, "copy the image again, or take it out of the model") from error


def read_image(path: Path, turned: bool = False) -> Pixels:
    """Read an image file as ``[height, width, 3]`` uint8 sRGB; transparency is ignored.

    Args:
        path: the file.
        turned: whether to apply the EXIF orientation; if not, the pixels come as they are stored.

    Raises:
        UserError: the file is missing, truncated, no image, or has more than 8 bits per channel.
    """
    with open_image(path) as image:
        upright = ImageOps.exif_transpose(image) if turned else image
        return np.array(upright.convert("RGB"))


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
    Image.fromarray(image).save(path, format="PNG", compress_level=1)
    return image
