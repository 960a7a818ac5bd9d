"""Capability ``learned_variance``: primitives learn how sure their colours are (ActiveNeRF, arXiv 2209.08546).

A pixel's colour is C = sum_i w_i c_i. Where the colours c_i of the primitives are independent and have variances
beta_i, C has the variance V = sum_i w_i^2 beta_i. The variances are learned by the likelihood of the photographs, and
tell how much of V a further view would remove.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras


@dataclass(frozen=True)
class VarianceLearning:
    """How variances are learned: as a logarithm per primitive, which starts at 0.

    The negative log-likelihood of the photographs, the mean of (C - C')^2 / (2 W) + log(W) / 2 with
    W = max(V + constant, floor), takes the place of L1; D-SSIM is added to it as in 3DGS.

    Attributes:
        learning_rate: Adam's, of the log-variances; None is the rate of the primitives' opacities.
        constant: added to the variance of each pixel.
        floor: least variance of a pixel in the likelihood, above 0.
        attenuated: whether a variance is blended with the square of alpha_i T_{i+1} in the place of alpha_i T_i, T_i
            being the transmittance in front of primitive i, and moves no primitive: its gradient goes to the variances
            alone, with alpha_i T_i. So it is in the code proposed to FisherRF (pull request 8).
    """

    learning_rate: float | None
    constant: float
    floor: float
    attenuated: bool


@dataclass(frozen=True)
class VarianceReduction:
    """How the variance that a view removes is counted.

    With V = constant + sum_i w_i^2 beta_i, a primitive's variance becomes 1 / (1 / beta_i + w_i^2 / V) once the pixel
    has been seen.

    Attributes:
        constant: added to the variance of each pixel.
        weighted: whether the variance of pixels is counted, V - sum_i w_i^2 / (1 / beta_i + w_i^2 / V), or that of the
            primitives in it, sum_i beta_i - sum_i 1 / (1 / beta_i + w_i^2 / V).
        saturated: whether nothing is left after the view in a pixel whose blending ended before its last primitive
            because hardly any light was left.
    """

    constant: float
    weighted: bool
    saturated: bool


@runtime_checkable
class HasLearnedVariance(Protocol):
    """Capability ``learned_variance``."""

    def learn_variance(self, rule: VarianceLearning) -> None:
        """Learn variances by ``rule`` from here on; only before the first step, and once.

        Raises:
            ValueError: it is too late, or variances are learned already.
        """
        ...

    def variance_reduction(self, cameras: Cameras, rule: VarianceReduction) -> npt.NDArray[np.float64]:
        """Return, for each of n cameras of any sizes, the variance that its view removes, summed over pixels: ``[n]``.

        Raises:
            ValueError: no variance is learned.
        """
        ...
