"""The contract of a 3D representation, and how a selector asks for more than rendering."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeVar, cast, runtime_checkable

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras
from avs.scene.views import Views
from avs.system.errors import UserError

if TYPE_CHECKING:
    from torch import Tensor

FloatImages = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Rendering:
    """What a representation looks like from n cameras of one image size.

    Attributes:
        rgb: ``[n, height, width, 3]`` float32 in 0..1.
        depth: ``[n, height, width]`` float32, expected distance along the optical axis in scene units: the blended
            depth divided by ``alpha``; 0 where ``alpha`` is 0.
        alpha: ``[n, height, width]`` float32 in 0..1, accumulated opacity.
    """

    rgb: FloatImages
    depth: FloatImages
    alpha: FloatImages


@runtime_checkable
class Renderer(Protocol):
    """All that a 2D selector may use of a representation."""

    def render(self, cameras: Cameras) -> Rendering:
        """Render ``cameras``, which share one image size.

        Raises:
            ValueError: the image sizes differ.
        """
        ...


class Representation(Renderer, Protocol):
    """What the loop of ``avs.nvs.loop`` uses of a representation."""

    @property
    def primitives(self) -> int:
        """Number of primitives (Gaussians, for Gaussian splatting)."""
        ...

    def fit(self, views: Views, iterations: int) -> None:
        """Optimise on ``views`` for ``iterations`` more steps; schedules go on from where the last call ended."""
        ...

    def save(self, path: Path) -> None:
        """Write a checkpoint atomically: parameters, optimiser, counters and generator state."""
        ...

    def load(self, path: Path) -> None:
        """Restore a checkpoint, so that further steps give the same bits as if there had been no interruption."""
        ...


@runtime_checkable
class Copyable(Protocol):
    """Capability ``copy``."""

    def copy(self) -> Representation:
        """Return a copy that goes on exactly as this one would: parameters, optimiser, counters, generator.

        Nothing done to one of the two changes the other.
        """
        ...


@dataclass(frozen=True)
class FisherInformation:
    """Diagonal Fisher information of one rendering, without the primitives that do not show in it: they have none.

    Per parameter it is the sum over pixels of the squared derivative of the pixel's channel sum (FisherRF, arXiv
    2311.17874, as its kernel computes it).

    Attributes:
        rows: the m primitives that show, ``[m]`` int64, ascending.
        values: ``[m, parameters]`` float32, not negative; a parameter's column is the same in every view.
        primitives: number of all primitives.
    """

    rows: npt.NDArray[np.int64]
    values: npt.NDArray[np.float32]
    primitives: int


@runtime_checkable
class HasFisherDiagonal(Protocol):
    """Capability ``fisher_diagonal``."""

    def fisher_diagonal(self, cameras: Cameras, chain: str, parameters: Sequence[str]) -> Iterator[FisherInformation]:
        """Yield the exact diagonal Fisher information of one camera's rendering after another.

        Args:
            cameras: the cameras, of any sizes.
            chain: how the derivative of an activation enters: ``once`` as FisherRF's code has it, ``squared`` as the
                diagonal of the Gauss-Newton matrix has it.
            parameters: names of the groups of parameters that get columns.
        """
        ...


@runtime_checkable
class HasFisherProbes(Protocol):
    """Capability ``fisher_probes``."""

    def fisher_probes(
        self, cameras: Cameras, chain: str, parameters: Sequence[str], probes: int, seeds: Sequence[int]
    ) -> Iterator[FisherInformation]:
        """Yield unbiased estimates of what ``fisher_diagonal`` yields.

        Args:
            cameras: the cameras, of any sizes.
            chain: as in ``fisher_diagonal``.
            parameters: as in ``fisher_diagonal``.
            probes: number of random sign images; the standard deviation of an estimate is at most sqrt(2 / probes)
                times its mean.
            seeds: of the sign images, one per camera.
        """
        ...


@dataclass(frozen=True)
class PrimitiveParameter:
    """A number more that each primitive has and the optimisation learns.

    It follows the primitives as their other parameters do: copied when one is cloned or split, and removed with it.

    Attributes:
        initial: its value at the start.
        learning_rate: of Adam; None is the rate of the primitives' opacities.
    """

    initial: float
    learning_rate: float | None = None


class Extension(Protocol):
    """What a method adds to the optimisation of a reconstruction: parameters, and a data term in the place of L1.

    Attributes:
        parameters: what is learned for each primitive, by name.
        attenuated: whether a variance is blended with the square of alpha_i T_{i+1} in the place of alpha_i T_i, T_i
            being the transmittance in front of primitive i, and moves no primitive: its gradient goes to the variances
            alone, with alpha_i T_i. So it is in the code proposed to FisherRF (pull request 8).
    """

    @property
    def parameters(self) -> Mapping[str, PrimitiveParameter]:
        """See above."""
        ...

    @property
    def attenuated(self) -> bool:
        """See above."""
        ...

    def variances(self, values: Mapping[str, Tensor]) -> Tensor:
        """Return the primitives' variances ``[n]``, positive, from the values ``[n]`` of ``parameters``."""
        ...

    def data_term(self, image: Tensor, variance: Tensor, photograph: Tensor) -> Tensor:
        """Return how badly a rendering fits its photograph, a scalar; D-SSIM is added to it as in 3DGS.

        Args:
            image: ``[height, width, 3]`` float32, not clamped.
            variance: ``[height, width]``, the sum over primitives of their variance times their squared weight.
            photograph: ``[height, width, 3]`` float32 in 0..1.
        """
        ...


@runtime_checkable
class TakesExtension(Protocol):
    """Capability ``extend``."""

    def extend(self, extension: Extension) -> None:
        """Optimise by ``extension`` from here on; only before the first step, and once.

        Raises:
            ValueError: it is too late, or there is an extension already.
        """
        ...


@dataclass(frozen=True)
class VarianceReduction:
    """How the variance that a view removes is counted (ActiveNeRF, arXiv 2209.08546).

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
class HasVarianceReduction(Protocol):
    """Capability ``variance_reduction``, of a representation that was extended."""

    def variance_reduction(self, cameras: Cameras, rule: VarianceReduction) -> npt.NDArray[np.float64]:
        """Return, for each of n cameras of any sizes, the variance that its view removes, summed over pixels: ``[n]``.

        Raises:
            ValueError: there is no extension.
        """
        ...


@runtime_checkable
class HasBlendingWeights(Protocol):
    """Capability of a representation whose pixels are weighted sums over primitives."""

    @property
    def centres(self) -> npt.NDArray[np.float32]:
        """Positions of the primitives, ``[primitives, 3]``, world coordinates."""
        ...

    def blended_values(self, camera: Cameras, values: npt.NDArray[np.float32]) -> FloatImages:
        """Return the image ``[height, width]`` of one value per primitive, blended as colours are, 0 behind.

        Args:
            camera: one camera.
            values: ``[primitives]``.
        """
        ...

    def front_weights(
        self, camera: Cameras, image: FloatImages, transmittance: float
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
        """Return, per primitive, the sum of weight times ``image`` over pixels, and the number of these pixels.

        A primitive's pixels are those where it is blended and the transmittance in front of it is above
        ``transmittance``.

        Args:
            camera: one camera.
            image: ``[height, width]``.
            transmittance: 0 for all of a primitive's pixels.
        """
        ...


Capability = TypeVar("Capability")


def capability(representation: Renderer, protocol: type[Capability], method: str) -> Capability:
    """Return ``representation`` as ``protocol``, which must be runtime-checkable.

    Raises:
        UserError: the representation lacks the capability that ``method`` needs.
    """
    if not isinstance(representation, protocol):
        name = type(representation).__name__
        raise UserError(
            method,
            f"needs the capability {protocol.__name__}, which {name} lacks",
            "choose a representation that has it, or another method",
        )
    return cast(Capability, representation)
