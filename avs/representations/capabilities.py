"""What a representation may offer beside fitting and rendering, by name, and how a method asks for it.

A kind of representation names what it offers, a method names what it needs; both can be compared without torch.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol, TypeVar, cast, runtime_checkable

import numpy as np
import numpy.typing as npt

from avs.representations.base import FloatImages, Renderer, Representation, unwrapped
from avs.representations.learned_variance import HasLearnedVariance
from avs.scene.cameras import Cameras
from avs.system.errors import UserError


@runtime_checkable
class Copyable(Protocol):
    """Capability ``copy``."""

    def copy(self, seed: int | None = None) -> Representation:
        """Return a copy that goes on exactly as this one would: parameters, optimiser, counters, generator.

        Nothing done to one of the two changes the other.

        Args:
            seed: of the random choices of the copy from here on, independent of this one's; None goes on with them.
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


@runtime_checkable
class HasBlendingWeights(Protocol):
    """Capability ``blending_weights``, of a representation whose pixels are weighted sums over primitives."""

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


CAPABILITIES: Mapping[str, type] = MappingProxyType(
    {
        "copy": Copyable,
        "fisher_diagonal": HasFisherDiagonal,
        "fisher_probes": HasFisherProbes,
        "blending_weights": HasBlendingWeights,
        "learned_variance": HasLearnedVariance,
    }
)
"""The protocol of each capability, by the name that ``Kind.offers`` and ``Method.needs`` have for it."""

Capability = TypeVar("Capability")


def capability(representation: Renderer, protocol: type[Capability], method: str) -> Capability:
    """Return ``representation``, or what it is wrapped around, as ``protocol``, one of ``CAPABILITIES``.

    Raises:
        UserError: the representation lacks the capability that ``method`` needs.
    """
    inner = unwrapped(representation)
    if not isinstance(inner, protocol):
        (name,) = (name for name, known in CAPABILITIES.items() if known is protocol)
        raise UserError(
            method,
            f"needs the capability {name}, which {type(inner).__name__} lacks",
            "choose a representation that has it, or another method",
        )
    return cast(Capability, inner)
