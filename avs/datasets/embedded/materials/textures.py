"""Textures by name: photographs and procedures. All procedures repeat without a seam."""

from __future__ import annotations

import zlib

import numpy as np

from avs.datasets.embedded.materials import textures_building, textures_fabric, textures_nature
from avs.datasets.embedded.materials.library_photographs import photograph
from avs.datasets.embedded.materials.patterns import Texture, texture

PROCEDURES = textures_building.PROCEDURES | textures_fabric.PROCEDURES | textures_nature.PROCEDURES

PICTURES = ("astronaut", "cat", "coffee", "cameraman", "motorcycle", "rocket", "galaxies", "retina", "coins", "tissue")
"""Photographs that hang on walls and are printed on things."""


def make_texture(name: str, size: int, seed: int) -> Texture:
    """Return the texture ``name``, a key of ``PROCEDURES`` or ``CROPS``, at ``size`` texels square."""
    if name not in PROCEDURES:
        return texture(photograph(name, size))
    # crc32, because hash() of a string differs from process to process.
    return PROCEDURES[name](size, np.random.default_rng([seed, zlib.crc32(name.encode())]))
