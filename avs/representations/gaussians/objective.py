"""What one step of the optimisation minimises: the loss of 3DGS, or the likelihood by which variances are learned."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from torch import Tensor

from avs.rasterizer.likelihood import negative_log_likelihood
from avs.rasterizer.losses import Target, photometric_loss
from avs.rasterizer.photometric_step import photometric_step
from avs.rasterizer.rasterization import rasterization
from avs.rasterizer.variance_rasterization import rasterization_with_variance
from avs.representations.gaussians.parameters import Parameters, PrimitiveParameter
from avs.representations.learned_variance import VarianceLearning

LOG_VARIANCES = "log_variances"
"""Name of the parameter ``[n]``, the logarithm of each Gaussian's variance."""


class Objective(Protocol):
    """A loss of one rendering."""

    @property
    def parameters(self) -> Mapping[str, PrimitiveParameter]:
        """What is learned for each Gaussian beside the parameters of 3DGS."""
        ...

    def __call__(
        self, parameters: Parameters, arguments: dict[str, Any], target: Target
    ) -> tuple[Tensor, dict[str, Any]]:
        """Render one camera and return the loss, a scalar, with what the rasteriser tells of the rendering.

        Args:
            parameters: the trainable tensors.
            arguments: of the rasteriser.
            target: the camera's photograph.
        """
        ...


class PhotometricObjective:
    """The loss of 3DGS, ``losses.photometric_loss``."""

    parameters: Mapping[str, PrimitiveParameter] = {}

    def __init__(self, ssim_weight: float) -> None:
        """Take the weight of D-SSIM, in 0..1; L1 has the rest."""
        self._ssim_weight = ssim_weight

    def __call__(
        self, parameters: Parameters, arguments: dict[str, Any], target: Target
    ) -> tuple[Tensor, dict[str, Any]]:
        """See ``Objective``."""
        if target.moments is not None:
            return photometric_step(**arguments, target=target, ssim_weight=self._ssim_weight)
        image, _, meta = rasterization(**arguments, packed=False)
        return photometric_loss(image[0], target, self._ssim_weight), meta


class LikelihoodObjective:
    """The likelihood of the photographs in the place of L1, beside D-SSIM; each Gaussian learns a log-variance.

    Attributes:
        rule: how variances are learned.
        parameters: the log-variances.
    """

    def __init__(self, rule: VarianceLearning, ssim_weight: float) -> None:
        """Take the weight of D-SSIM, in 0..1; the likelihood has the rest."""
        self.rule = rule
        self.parameters: Mapping[str, PrimitiveParameter] = {
            LOG_VARIANCES: PrimitiveParameter(initial=0.0, learning_rate=rule.learning_rate)
        }
        self._ssim_weight = ssim_weight

    def __call__(
        self, parameters: Parameters, arguments: dict[str, Any], target: Target
    ) -> tuple[Tensor, dict[str, Any]]:
        """See ``Objective``."""
        rule = self.rule
        image, variance, meta = rasterization_with_variance(
            **arguments, variances=parameters[LOG_VARIANCES].exp(), attenuated=rule.attenuated
        )
        data = negative_log_likelihood(image[0], variance[0] + rule.constant, target.image, rule.floor)
        dissimilarity = photometric_loss(image[0], target, 1.0)
        return (1 - self._ssim_weight) * data + self._ssim_weight * dissimilarity, meta
