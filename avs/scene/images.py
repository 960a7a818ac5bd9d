"""Image files: reading, writing without loss, and hashing of pixels."""

from __future__ import annotations

import contextlib
import hashlib
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from avs.scene.pixel_forms import Color, rgb_image, turned, upright_orientation
from avs.system.errors import UserError
from avs.system.regular_files import check_regular

Pixels = npt.NDArray[np.uint8]

LARGEST = 400_000_000
"""An image with more pixels is refused: with 4 bytes for each, it would take 1.6 GB."""

BLACK: Color = (0.0, 0.0, 0.0)

Image.MAX_IMAGE_PIXELS = None  # Pillow's limit, 89 million, is lower than what cameras take; LARGEST is checked instead

_UPRIGHT = 1  # the EXIF orientation of an image that is shown as it is stored


@dataclass(frozen=True)
class Header:
    """What an image file says of itself, read without its pixels.

    Attributes:
        size: width and height of the pixels as they are stored.
        orientation: of EXIF, 1 to 8; 1 where there is none.
        odd: whether EXIF has an orientation that makes no sense, which counts as 1.
        form: name of the file format, such as ``JPEG``.
        deep: whether its channels have 16 bits.
        plain: whether any program reads the same 8-bit sRGB values from it.
        transparent: whether it has an alpha channel or a transparent colour.
        frames: whether other frames or pages follow the first one, which is used.
        profile: whether it has a colour profile that is not sRGB's, or another gamma.
    """

    size: tuple[int, int]
    orientation: int
    odd: bool
    form: str
    deep: bool
    plain: bool
    transparent: bool
    frames: bool
    profile: bool


def read_header(path: Path) -> Header:
    """Read what the image file says of itself.

    Raises:
        UserError: the file is missing, no image, or too large.
    """
    with _opened(path) as image:
        stated = upright_orientation(image)
        orientation = stated or _UPRIGHT
        form = image.format or ""
        transparent = image.mode in ("LA", "La", "PA", "RGBA", "RGBa") or "transparency" in image.info
        frames = form != "MPO" and bool(getattr(image, "is_animated", False))
        tiles = getattr(image, "tile", [])  # how the file's pixels are packed, such as "RGB;16B"
        deep = image.mode.startswith("I;16") or any(";16" in str(tile.args) for tile in tiles)
        eight_bit = image.mode in ("L", "RGB") and not deep
        return Header(
            size=_stored_size(image, orientation),
            orientation=orientation,
            odd=stated is None,
            form=form,
            deep=deep,
            plain=eight_bit and not transparent and not frames and orientation == _UPRIGHT,
            transparent=transparent,
            frames=frames,
            profile=_has_other_profile(image),
        )


def read_image(path: Path, orientation: int = _UPRIGHT, background: Color = BLACK) -> Pixels:
    """Read an image file as ``[height, width, 3]`` uint8 sRGB; see ``open_rgb``."""
    return np.array(open_rgb(path, orientation, background))


def open_rgb(path: Path, orientation: int = _UPRIGHT, background: Color = BLACK) -> Image.Image:
    """Read an image file as an RGB image of 8 bits per channel; see ``avs.scene.pixel_forms`` for what is converted.

    Args:
        path: the file.
        orientation: EXIF orientation to apply to the pixels as they are stored; by default they stay so.
        background: colour behind transparent pixels, sRGB in 0..1.

    Raises:
        UserError: the file is missing, truncated, no image, or its values have no scale that is known.
    """
    with _opened(path) as image:
        own = (upright_orientation(image) or _UPRIGHT) if image.format == "TIFF" else _UPRIGHT
        image.load()
        pixels = rgb_image(image, path, own, background)
        return turned(pixels, orientation)


def is_translucent(path: Path) -> bool:
    """Return whether a pixel of an image file is not opaque; an alpha channel alone does not make it so.

    Raises:
        UserError: as ``open_rgb``.
    """
    with _opened(path) as image:
        image.load()
        try:
            opacity = image.convert("RGBA").getchannel("A")
        except ValueError:  # of grey with 16 bits, which is refused where it is read
            return True
        return bool(np.asarray(opacity).min() < 255)


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


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Image.Image]:
    """Open an image file; a fault of it inside the block becomes a ``UserError``."""
    try:
        check_regular(path)
        with Image.open(path) as image:
            _check_size(path, image)
            yield image
    except (UserError, MemoryError):
        raise
    except FileNotFoundError as error:
        raise UserError(path, "the image is missing, but the model names it", "restore the file") from error
    except Exception as error:  # Pillow's decoders raise whatever the bytes of a damaged file bring about
        if isinstance(error, OSError) and error.errno is not None:
            raise
        told = " ".join(f"{type(error).__name__}: {error}".split())
        fault = f"the image is damaged or cut off, or of a form that cannot be read ({told})"
        remedy = "copy it again, or save it as PNG or JPEG with 8 bits per channel, or take it out of the model"
        raise UserError(path, fault, remedy) from error


def _check_size(path: Path, image: Image.Image) -> None:
    if image.width * image.height > LARGEST:
        fault = f"the image has {image.width} x {image.height} pixels, more than {LARGEST // 10**6} million"
        raise UserError(path, fault, "put a smaller copy of the same shape in its place; the model may stay as it is")


def _stored_size(image: Image.Image, orientation: int) -> tuple[int, int]:
    """Return the size of the pixels as they are stored; Pillow gives TIFF files the size that they have upright."""
    return image.size[::-1] if image.format == "TIFF" and orientation >= 5 else image.size


def _has_other_profile(image: Image.Image) -> bool:
    """Whether the file says that its values are not sRGB, by an ICC profile or PNG's gamma."""
    profile, gamma = image.info.get("icc_profile"), image.info.get("gamma")
    if isinstance(profile, bytes):
        return b"sRGB" not in profile and "sRGB".encode("utf-16-be") not in profile
    return isinstance(gamma, float) and "srgb" not in image.info and abs(gamma - 1 / 2.2) > 0.01
