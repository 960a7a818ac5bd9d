"""The contract of a 3D representation, and how a selector asks for more than rendering."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeVar, cast, runtime_checkable

import numpy as np
import numpy.typing as npt

from avs.cameras import Cameras
from avs.errors import UserError
from avs.views import Views

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
    """What the loop of ``avs.episode`` uses of a representation."""

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


@runtime_checkable
class HasFisherDiagonal(Protocol):
    """Capability ``fisher_diagonal``."""

    def fisher_diagonal(self, cameras: Cameras, chain: str) -> Iterator[npt.NDArray[np.float32]]:
        """Yield, camera by camera, the diagonal Fisher information of one rendering.

        Each is a ``[primitives, parameters]`` array of non-negative float32: per parameter the sum over pixels of the
        squared derivative of the pixel's channel sum (FisherRF, arXiv 2311.17874, as its kernel computes it).

        Args:
            cameras: the cameras, of any sizes.
            chain: how the derivative of an activation enters: ``once`` as FisherRF's code has it, ``squared`` as the
                diagonal of the Gauss-Newton matrix has it.
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
