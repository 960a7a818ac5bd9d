"""What one step of the optimisation minimises: the loss of 3DGS, or that of a method's extension."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from torch import Tensor

from avs.rasterizer.losses import Target, photometric_loss
from avs.rasterizer.rasterization import rasterization
from avs.representations.base import Extension, PrimitiveParameter
from avs.representations.gaussians.parameters import Parameters
from avs.representations.gaussians.variance import rasterization_with_variance


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
        image, _, meta = rasterization(**arguments, packed=False)
        return photometric_loss(image[0], target, self._ssim_weight), meta


class ExtendedObjective:
    """The data term of an extension in the place of L1, beside D-SSIM."""

    def __init__(self, extension: Extension, ssim_weight: float) -> None:
        """Take the weight of D-SSIM, in 0..1; the data term has the rest."""
        self.extension = extension
        self._ssim_weight = ssim_weight

    @property
    def parameters(self) -> Mapping[str, PrimitiveParameter]:
        """The extension's."""
        return self.extension.parameters

    def __call__(
        self, parameters: Parameters, arguments: dict[str, Any], target: Target
    ) -> tuple[Tensor, dict[str, Any]]:
        """See ``Objective``."""
        variances = self.variances(parameters)
        image, variance, meta = rasterization_with_variance(
            **arguments, variances=variances, attenuated=self.extension.attenuated
        )
        data = self.extension.data_term(image[0], variance[0], target.image)
        dissimilarity = photometric_loss(image[0], target, 1.0)
        return (1 - self._ssim_weight) * data + self._ssim_weight * dissimilarity, meta

    def variances(self, parameters: Parameters) -> Tensor:
        """Return each Gaussian's variance, ``[n]``."""
        return self.extension.variances({name: parameters[name] for name in self.extension.parameters})
