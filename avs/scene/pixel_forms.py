"""From every form of pixels that image files have to RGB with 8 bits per channel, or one line that says why not.

Pillow reads 16-bit colours as if their upper half were all, and takes TIFF files of 16 bits apart wrongly where their
planes are stored one after another. Hence 8 bits are left to Pillow, 16 are read by OpenCV, and all else is refused:
signed numbers, 32 bits and floating-point numbers have no scale that a reader could know.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from avs.system.errors import UserError

Color = tuple[float, float, float]

_ORIENTATION = 0x0112  # EXIF tag; 1 is upright, 5 to 8 exchange width and height
_TURNS = {
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}
_INVERSE = {6: 8, 8: 6}

# TIFF tags, and their values that are read.
_BITS, _PHOTOMETRIC, _PLANES, _NUMBERS = 258, 262, 284, 339
_BLACK_IS_ZERO, _RGB, _INTERLEAVED, _UNSIGNED, _UNDEFINED = 1, 2, 1, 1, 4

_PEAK = 1 << 14  # 16-bit samples that stay below hold 10, 12 or 14 bits, unless the photograph is all but black
_BAND = 256  # rows

_REMEDY = "convert it to 8 bits per channel"


def upright_orientation(image: Image.Image) -> int | None:
    """Return the EXIF orientation, 1 to 8, of an image before it is loaded; 1 if there is none, None for nonsense."""
    if image.format == "PNG" and not {"exif", "Raw profile type exif"} & image.info.keys():
        return 1  # Pillow would decode the whole image in search of EXIF behind it
    try:
        orientation = image.getexif().get(_ORIENTATION, 1)
    except Exception:  # Pillow's reader of EXIF raises whatever the bytes bring about
        return None
    return orientation if type(orientation) is int and 1 <= orientation <= 8 else None


def turned(image: Image.Image, orientation: int) -> Image.Image:
    """Return ``image`` after an EXIF orientation."""
    return image.transpose(_TURNS[orientation]) if orientation in _TURNS else image


def rgb_image(image: Image.Image, path: Path, applied: int, background: Color) -> Image.Image:
    """Return a loaded image as RGB with 8 bits per channel, as it is stored.

    Transparent pixels are composited on ``background``, in sRGB values as NeRF's loaders do it. 16-bit samples are
    divided by 257. CMYK is converted without a colour profile, and so are all others: values count as sRGB.

    Args:
        image: the image, loaded.
        path: its file.
        applied: the orientation that Pillow has applied already.
        background: colour behind transparent pixels, sRGB in 0..1.

    Raises:
        UserError: the samples are neither of 8 nor of 16 bits, or their scale is not known.
    """
    bits = _bits(image, path)
    if bits > 8:
        if applied != 1 or "transparency" in image.info:
            extra = "an orientation" if applied != 1 else "a transparent colour"
            raise UserError(
                path, f"the image has 16 bits per channel and {extra}, which are not read together", _REMEDY
            )
        deep = _from_sixteen_bits(path)
        return deep if deep.mode == "RGB" else _on_background(deep, background)
    if image.mode in ("F", "I", "LAB", "HSV") or image.mode.startswith("I;"):
        raise UserError(path, f"the image has pixels of mode {image.mode}, whose scale is not known", _REMEDY)
    stored = turned(image, _INVERSE.get(applied, applied))
    if stored.mode in ("LA", "La", "PA", "RGBA", "RGBa") or "transparency" in image.info:
        return _on_background(stored, background)
    return stored if stored.mode == "RGB" else stored.convert("RGB")


def _bits(image: Image.Image, path: Path) -> int:
    """Return 8 for samples of up to 8 bits, which Pillow reads, and 16 for those that OpenCV reads.

    Raises:
        UserError: neither can.
    """
    if image.format == "PNG":
        with open(path, "rb") as stream:
            return 16 if stream.read(25)[24:] == b"\x10" else 8  # the field "bit depth"
    tags = getattr(image, "tag_v2", None) if image.format == "TIFF" else None
    if tags is None:
        return 8
    depths = _numbers(tags.get(_BITS, 1))
    numbers = _numbers(tags.get(_NUMBERS, _UNSIGNED))
    if max(depths) <= 8 and set(numbers) <= {_UNSIGNED, _UNDEFINED}:
        return 8
    told = f"{max(depths)} bits per channel" + ("" if set(numbers) <= {_UNSIGNED, _UNDEFINED} else ", signed or real")
    readable = set(depths) == {16} and set(numbers) == {_UNSIGNED} and len(depths) in (1, 3, 4)
    forms = tags.get(_PHOTOMETRIC), tags.get(_PLANES, _INTERLEAVED)
    if not readable or forms not in ((_BLACK_IS_ZERO, _INTERLEAVED), (_RGB, _INTERLEAVED)):
        raise UserError(path, f"the image has a form of TIFF that is not read ({told})", _REMEDY)
    return 16


def _numbers(value: object) -> tuple[int, ...]:
    return tuple(value) if isinstance(value, Sequence) else (int(str(value)),)


def _from_sixteen_bits(path: Path) -> Image.Image:
    """Return a PNG or TIFF file of 16 bits per channel as RGB or RGBA with 8."""
    import cv2

    samples = cv2.imdecode(np.fromfile(path, np.uint8), cv2.IMREAD_UNCHANGED)
    if samples is None or samples.dtype != np.uint16:
        raise UserError(path, "the image is damaged, or has a form of 16 bits per channel that is not read", _REMEDY)
    peak = int(samples.max() if samples.ndim == 2 else samples[..., :3].max())
    if 0 < peak < _PEAK:
        fault = (
            f"the image has 16 bits per channel but no value above {peak} of 65535, so that it seems to hold fewer bits"
        )
        raise UserError(path, fault, f"{_REMEDY}, with the scale that it was taken with")
    values: npt.NDArray[np.uint8] = (samples // 257 + (samples % 257 > 128)).astype(np.uint8)
    if values.ndim == 2:
        return Image.fromarray(values).convert("RGB")
    return Image.fromarray(np.ascontiguousarray(values[..., [2, 1, 0, 3][: values.shape[2]]]))


def _on_background(image: Image.Image, background: Color) -> Image.Image:
    """Return an image with transparency on ``background``, made in bands so that no further copy is in memory."""
    red, green, blue = (round(255 * min(max(value, 0.0), 1.0)) for value in background)
    base = Image.new("RGB", image.size, (red, green, blue))
    for top in range(0, image.height, _BAND):
        band = image.crop((0, top, image.width, min(top + _BAND, image.height))).convert("RGBA")
        base.paste(band.convert("RGB"), (0, top), mask=band.getchannel("A"))
    return base
