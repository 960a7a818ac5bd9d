"""Fixed random position codes of the tokens."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional


class PositionCodes(nn.Module):
    """Standard normal random numbers on a square grid, interpolated to any grid of tokens, as in CrossScore.

    They are not trained, but belong to the weights: another draw would be another input. Query and reference images get
    the same codes, so they tell where in its image a token lies, not in which image.
    """

    codes: Tensor

    def __init__(self, channels: int, size: int, seed: int) -> None:
        """Draw ``[1, channels, size, size]`` codes from a generator of their own, seeded with ``seed``."""
        super().__init__()
        generator = torch.Generator().manual_seed(seed)
        self.register_buffer("codes", torch.randn(1, channels, size, size, generator=generator))

    def forward(self, rows: int, columns: int) -> Tensor:
        """Return ``[1, channels, rows, columns]``: bilinear, the corner tokens get the corner codes."""
        return functional.interpolate(self.codes, (rows, columns), mode="bilinear", align_corners=True)
