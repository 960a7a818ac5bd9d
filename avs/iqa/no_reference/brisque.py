"""BRISQUE: a support vector regression on statistics of locally normalised luminance (Mittal et al., TIP 2012)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from avs.system.errors import UserError
from avs.system.weights.cache import COMMAND
from avs.system.weights.reading import read_torch

if TYPE_CHECKING:
    from torch import Tensor

FEATURES = 36
"""18 statistics at each of two scales."""

_REMEDY = f"{COMMAND} brisque"


class BRISQUE:
    """pyiqa's function ``brisque`` with given support vectors, in float64; lower is better.

    Its shape parameters are the nearest of a table in steps of 0.001. In float32 a change of the pixels by 1e-7 takes
    them to a neighbour, and a score of 2.88 to anything between 2.86 and 2.88: another one on another processor. An
    image without any luminance gets NaN: it has no statistics, and pyiqa's function refuses it.

    Args:
        coefficients: ``[n]`` coefficients of the support vectors.
        vectors: ``[n, 36]`` support vectors.
    """

    def __init__(self, coefficients: Tensor, vectors: Tensor) -> None:
        self._coefficients = coefficients
        self._vectors = vectors

    def __call__(self, images: Tensor) -> Tensor:
        """Return ``[n]`` scores of RGB images ``[n, 3, height, width]`` in 0..1."""
        from pyiqa.archs.brisque_arch import brisque

        scores = images.new_full((len(images),), float("nan"))
        lit = images.amax((1, 2, 3)) > 0
        if lit.any():
            scores[lit] = brisque(images[lit].double(), sv_coef=self._coefficients, sv=self._vectors).to(scores)
        return scores


def read_support_vectors(path: Path) -> tuple[Tensor, Tensor]:
    """Return the coefficients and the support vectors of a file of pyiqa's.

    Raises:
        UserError: the file is damaged, holds objects, or something else.
    """
    import torch

    values = read_torch(path, _REMEDY)
    shapes = [tuple(value.shape) for value in values] if _are_tensors(values) else []
    if len(shapes) != 2 or len(shapes[0]) != 1 or shapes[1] != (*shapes[0], FEATURES):
        raise UserError(path, f"not BRISQUE's support vectors: shapes {shapes}, expected [(n,), (n, 36)]", _REMEDY)
    coefficients, vectors = values
    if not (torch.isfinite(coefficients).all() and torch.isfinite(vectors).all()):
        raise UserError(path, "holds numbers that are not finite", _REMEDY)
    return coefficients, vectors


def _are_tensors(values: object) -> bool:
    import torch

    return isinstance(values, (tuple, list)) and all(isinstance(value, torch.Tensor) for value in values)
