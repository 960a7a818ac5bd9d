"""Materials of things, and the colours that people choose for them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.geometry.mesh_model import Color, Material
from avs.datasets.embedded.materials.textures import PICTURES

Generator = np.random.Generator

CERAMIC = Material("marble", 0.3, roughness=0.18, reflectance=0.05)
GLAZED = Material("glaze", 0.35, roughness=0.2, reflectance=0.05)
TERRACOTTA = Material("concrete", 0.5, (1.6, 0.75, 0.45), roughness=0.85, relief=0.004)
GLASS = Material("marble", 0.5, (0.1, 0.22, 0.12), roughness=0.08, reflectance=0.06)
STEEL = Material("metal", 0.4, roughness=0.25, reflectance=0.55)
WOOD = Material("wood", 0.8, roughness=0.45)
PAGES = Material("paper", 0.06, roughness=0.9)
CLOTH = Material("weave", 0.25, roughness=0.95)
CARDBOARD = Material("weave", 0.12, (0.75, 0.55, 0.36), roughness=0.9)
WAX = Material("fruit", 0.3, roughness=0.4)


# Dyes and glazes that people have around them: brick, wine, navy, slate, forest, olive, mustard, cream, terracotta,
# brown, teal, charcoal, rose.
_DYES = np.array(
    [
        (1, 0.34, 0.24),
        (1, 0.36, 0.42),
        (0.34, 0.5, 1),
        (0.72, 0.85, 1),
        (0.45, 1, 0.52),
        (0.86, 1, 0.46),
        (1, 0.74, 0.26),
        (1, 0.93, 0.78),
        (1, 0.56, 0.36),
        (1, 0.7, 0.48),
        (0.36, 0.94, 1),
        (0.92, 0.94, 1),
        (1, 0.66, 0.64),
    ]
)
# White, yellow, red, pink, violet, blue.
_PETALS = np.array([(1, 1, 0.94), (1, 0.8, 0.12), (1, 0.1, 0.08), (1, 0.45, 0.55), (0.65, 0.35, 1), (0.35, 0.45, 1)])


def _drawn(table: npt.NDArray[np.floating], rng: Generator, low: float, high: float) -> Color:
    mixed = np.clip(table[int(rng.integers(len(table)))] + 0.06 * rng.normal(size=3), 0.03, 1) * rng.uniform(low, high)
    return (float(mixed[0]), float(mixed[1]), float(mixed[2]))


def color(rng: Generator, low: float = 0.08, high: float = 0.75) -> Color:
    """Return the colour of a dye; its strongest channel is between ``low`` and ``high``."""
    return _drawn(_DYES, rng, low, high)


def blossom(rng: Generator) -> Color:
    """Return the colour of a flower."""
    return _drawn(_PETALS, rng, 0.6, 1.0)


def paint(rng: Generator) -> Color:
    """Return the pale colour of a painted wall."""
    hue = rng.dirichlet((6.0, 6.0, 4.0))
    pale = 0.78 + 0.3 * hue / hue.max()
    return (float(pale[0]), float(pale[1]), float(pale[2]))


def picture(rng: Generator, size: float = 1.0) -> Material:
    """Return one of the photographs as a printed surface ``size`` metres wide."""
    return Material(PICTURES[int(rng.integers(len(PICTURES)))], size, roughness=0.35)
