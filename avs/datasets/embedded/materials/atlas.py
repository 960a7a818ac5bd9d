"""All textures of a scene in one flat array with their coarser levels, and the look-up by footprint.

Pyramids of halved resolutions keep distant surfaces from aliasing (Williams 1983). One texel is eight bytes, fetched as
one 64-bit integer: colour (square root of linear reflectance), gloss and the two slopes of the relief.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.materials.patterns import Texture
from avs.datasets.embedded.materials.textures import make_texture

Array = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Surface:
    """What a look-up returns for n samples.

    Attributes:
        color: ``[n, 3]`` linear reflectance.
        gloss: ``[n]`` in 0..1.
        slope: ``[n, 2]`` derivative of the height (0..1) with respect to the texture coordinates.
    """

    color: Array
    gloss: Array
    slope: Array


class Atlas:
    """Textures of equal size, all powers of two down to one texel."""

    def __init__(self, names: Sequence[str], levels: int, seed: int) -> None:
        """Make the textures ``names`` at 2**levels texels; ``seed`` varies the procedural ones."""
        self.names = tuple(names)
        self.levels = levels
        blocks, self._slope_scale, means = [], [], []
        for name in names:
            texture = make_texture(name, 1 << levels, seed)
            scale, block = _encode(texture, levels)
            blocks.append(block)
            self._slope_scale.append(scale)
            means.append(texture.color.mean(axis=(0, 1)))
        self._texels = np.concatenate(blocks)
        self._scales = np.array(self._slope_scale, np.float32)
        self.means = np.array(means, np.float32)
        """``[textures, 3]`` mean reflectance of each texture."""
        sizes = 1 << np.arange(levels, -1, -1)
        self._level_start = np.concatenate([[0], np.cumsum(sizes**2)])
        self._block = int(self._level_start[-1])

    def lookup(self, layer: npt.NDArray[np.integer], coordinates: Array, level: Array) -> Surface:
        """Interpolate bilinearly within one level of detail.

        Args:
            layer: ``[n]`` texture index.
            coordinates: ``[n, 2]`` texture coordinates, one unit per repeat.
            level: ``[n]`` level of detail, 0 the finest; rounded to the nearest and clipped to what exists.
        """
        step = np.clip(np.rint(level), 0, self.levels).astype(np.int64)
        size = np.int64(1) << (self.levels - step)
        base = layer.astype(np.int64) * self._block + self._level_start[step]
        position = coordinates * size[:, None].astype(np.float32) - np.float32(0.5)
        low = np.floor(position)
        part = position - low
        column, row = low[:, 0].astype(np.int64), low[:, 1].astype(np.int64)
        mask = size - 1
        left, right = column & mask, (column + 1) & mask
        upper, lower = base + (row & mask) * size, base + ((row + 1) & mask) * size
        total = np.zeros((len(step), 6), np.float32)
        weight_x, weight_y = part[:, 0], part[:, 1]
        for index, weight in (
            (upper + left, (1 - weight_x) * (1 - weight_y)),
            (upper + right, weight_x * (1 - weight_y)),
            (lower + left, (1 - weight_x) * weight_y),
            (lower + right, weight_x * weight_y),
        ):
            texels = self._texels[index].view(np.uint8).reshape(-1, 8)[:, :6]
            total += texels * weight[:, None]
        total *= np.float32(1 / 255)
        color = total[:, :3] * total[:, :3]
        slope = (total[:, 4:6] * 2 - np.float32(256 / 255)) * self._scales[layer][:, None]
        return Surface(color, total[:, 3], slope)


def _encode(texture: Texture, levels: int) -> tuple[float, npt.NDArray[np.uint64]]:
    """Return the scale of the slopes and all levels of ``texture``, finest first, as packed texels."""
    size = 1 << levels
    slope_x = (np.roll(texture.height, -1, 1) - np.roll(texture.height, 1, 1)) * (size / 2)
    slope_y = (np.roll(texture.height, -1, 0) - np.roll(texture.height, 1, 0)) * (size / 2)
    scale = max(float(np.quantile(np.abs(np.stack([slope_x, slope_y])), 0.995)), 1e-3)
    fields = np.concatenate([texture.color, np.stack([texture.gloss, slope_x, slope_y], -1)], axis=2)
    blocks = []
    for level in range(levels + 1):
        if level:
            fields = fields.reshape(fields.shape[0] // 2, 2, -1, 2, 6).mean(axis=(1, 3))
        packed = np.zeros((*fields.shape[:2], 8), np.uint8)
        packed[..., :3] = np.rint(np.sqrt(np.clip(fields[..., :3], 0, 1)) * 255)
        packed[..., 3] = np.rint(np.clip(fields[..., 3], 0, 1) * 255)
        packed[..., 4:6] = np.rint(np.clip(fields[..., 4:6] / scale, -1, 1) * 127 + 128)
        blocks.append(packed.reshape(-1).view(np.uint64))
    return scale, np.concatenate(blocks)
