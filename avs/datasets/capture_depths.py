"""Whether pictures of 16 bits per channel use them: 10 to 15 bits in their place would be read as dark pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from avs.datasets.capture_pictures import Picture
from avs.scene.images import open_rgb
from avs.system.errors import UserError

_MIDDLE = 128
"""Of 255; 15 bits reach up to it."""

_SHARE = 0.02
"""Of the pixels: hot ones, burnt-out lamps and a date are no more, and tell nothing of the scale."""


def check_depths(folder: Path, pictures: Sequence[Picture]) -> None:
    """Check that some of the pictures of 16 bits are bright; mostly the first tells, and no other is read.

    Args:
        folder: of the pictures, for the message.
        pictures: to be checked.

    Raises:
        UserError: all are so dark that they seem to hold fewer bits; or one is damaged.
    """
    deep = [picture for picture in pictures if picture.header.deep]
    if not deep or any(_is_bright(picture.path) for picture in deep):
        return
    fault = (
        f"of {len(deep)} images with 16 bits per channel none has {_SHARE:.0%} of its pixels above the middle of "
        "the scale, so that they seem to hold fewer bits"
    )
    remedy = "convert them to 8 bits per channel, with the scale that they were taken with"
    raise UserError(folder, fault, remedy)


def _is_bright(path: Path) -> bool:
    pixels = np.asarray(open_rgb(path))
    return bool((pixels.max(axis=2) > _MIDDLE).mean() > _SHARE)
