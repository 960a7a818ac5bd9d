"""The map as a representation: what the selectors of Task A may ask of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt
import torch
from torch.nn import Parameter

from avs.representations.base import FloatImages, Rendering
from avs.representations.capabilities import FisherInformation
from avs.representations.gaussians.blending_weights import WeightSums, blended_values, front_weights
from avs.representations.gaussians.initialization import SH_DEGREE_0
from avs.representations.gaussians.parameter_information import parameter_fisher
from avs.representations.gaussians.parameters import Parameters
from avs.representations.gaussians.probes import probe_views
from avs.representations.gaussians.rendering import rendered
from avs.representations.gaussians.training_state import checksum
from avs.scene.cameras import Cameras
from avs.slam.mapping.gaussian_map import MapTensors

_BLACK = (0.0, 0.0, 0.0)


class MapView:
    """A map as it is now; a ``Renderer`` with the capabilities of ``avs.slam.scoring.able_methods.OFFERS``.

    It cannot be fitted. Colours become spherical harmonics of degree 0, and the one scale of a Gaussian three.
    """

    def __init__(self, tensors: MapTensors) -> None:
        """Show ``tensors``, which are copied."""
        count = len(tensors["means"])
        values = {
            "means": tensors["means"],
            "scales": tensors["scales"].expand(count, 3),
            "quats": torch.tensor([1.0, 0.0, 0.0, 0.0]).expand(count, 4),
            "opacities": tensors["opacities"],
            "sh": ((tensors["rgb"] - 0.5) / SH_DEGREE_0)[:, None],
        }
        self._parameters: Parameters = {name: Parameter(value.detach().clone()) for name, value in values.items()}
        self._background = torch.tensor([_BLACK])

    @property
    def primitives(self) -> int:
        """Number of Gaussians."""
        return len(self._parameters["means"])

    def render(self, cameras: Cameras) -> Rendering:
        """Render ``cameras``, which share one image size; see ``avs.representations.base.Renderer``."""
        return rendered(self._parameters, cameras, 0, self._background)

    def fisher_diagonal(self, cameras: Cameras, chain: str, parameters: Sequence[str]) -> Iterator[FisherInformation]:
        """Yield the diagonal Fisher information of one camera after another."""
        return parameter_fisher(self._parameters, cameras, 0, _BLACK, chain, parameters)

    def fisher_probes(
        self, cameras: Cameras, chain: str, parameters: Sequence[str], probes: int, seeds: Sequence[int]
    ) -> Iterator[FisherInformation]:
        """Yield estimates of the same."""
        return probe_views(self._parameters, cameras, 0, self._background, chain, parameters, probes, seeds)

    @property
    def centres(self) -> npt.NDArray[np.float32]:
        """Positions of the Gaussians, ``[n, 3]``."""
        return np.asarray(self._parameters["means"].detach().numpy())

    def blended_values(self, camera: Cameras, values: npt.NDArray[np.float32]) -> FloatImages:
        """Return the image of one value per Gaussian."""
        return blended_values(self._parameters, camera, values)

    def front_weights(self, camera: Cameras, image: FloatImages, transmittance: float) -> WeightSums:
        """Return each Gaussian's sum of weight times image."""
        return front_weights(self._parameters, camera, image, transmittance)

    def fingerprint(self) -> int:
        """Return a checksum of all that a rendering depends on."""
        return checksum(self._parameters, {})
