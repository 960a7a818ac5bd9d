"""The contract of a 3D representation, and the static description of a kind of them, which is read without torch."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from avs.representations.needed_points import NeededPoints
from avs.scene.cameras import Cameras
from avs.scene.views import Views
from avs.system.models import StrictModel

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


@runtime_checkable
class Wrapper(Protocol):
    """A renderer around another one, such as one that keeps the clock. Capabilities are those of the inner one.

    Attributes:
        inner: what it is wrapped around.
    """

    @property
    def inner(self) -> Renderer:
        """See above."""
        ...


def unwrapped(renderer: Renderer) -> Renderer:
    """Return what ``renderer`` is wrapped around, however often; itself if it is no wrapper."""
    while isinstance(renderer, Wrapper):
        renderer = renderer.inner
    return renderer


class Representation(Renderer, Protocol):
    """What every loop uses of a representation; ``avs.representations.capabilities`` holds what else one may offer."""

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

    def export(self, folder: Path) -> None:
        """Write the model, as programs for its format open it, to the file ``Kind.exports`` of ``folder``."""
        ...


class RepresentationSettings(StrictModel):
    """Base of the settings of a kind of representation.

    A subclass narrows ``kind`` to the literal name of its kind, which is the field's default, and adds fields.
    """

    kind: str

    def needed_points(self) -> NeededPoints | None:
        """Return what every scene must have of points of structure from motion; None if it can do without."""
        return None


@dataclass(frozen=True)
class Kind:
    """One kind of representation: ``KIND`` of the sub-package of ``avs.representations`` that has its name.

    Attributes:
        settings: the type of its settings.
        offers: names of ``avs.representations.capabilities.CAPABILITIES``, of all that an instance can do.
        exports: name of the file that ``Representation.export`` writes.
        build: the function that makes an untrained one, as ``module:function``, imported when it is called. It takes
            the scene, the indices of the captured views ``[n]``, the settings, a seed and ``cpu`` or ``cuda``.
        on_cpu: those of ``offers`` that are computed on the CPU wherever an instance lies, so that their times are not
            to be compared with those of a GPU.
        compile: the function that compiles the CPU kernels, as ``module:function``, for a kind that has some.
    """

    settings: type[RepresentationSettings]
    offers: frozenset[str]
    exports: str
    build: str
    on_cpu: frozenset[str] = frozenset()
    compile: str | None = None

    @property
    def module(self) -> str:
        """The module with all of its code, for the rules of the workflow whose jobs fit one."""
        return self.build.partition(":")[0]
