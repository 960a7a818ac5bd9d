"""Which files are images, by their names."""

from __future__ import annotations

from pathlib import Path

_SUFFIXES = {".bmp", ".jpeg", ".jpg", ".png", ".tif", ".tiff", ".webp"}


def is_image(path: Path) -> bool:
    """Whether a file has the suffix of an image that can be read."""
    return path.suffix.lower() in _SUFFIXES
