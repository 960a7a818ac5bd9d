"""What every back end of structure from motion takes and gives, and its static description."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from pydantic import Field

from avs.scene.cameras import Cameras
from avs.scene.views import Views
from avs.sfm.cloud import Cloud
from avs.system.errors import UserError
from avs.system.models import Seed, StrictModel
from avs.system.reasons import Reason

Poses = Literal["known", "free"]
"""Whether a back end takes the poses of the cameras as they are, or finds its own. Focal lengths are known to both."""

FEWEST = 2
"""Views that a point in space needs."""


@dataclass(frozen=True)
class Reconstruction:
    """What a back end makes of a list of views. That it makes nothing of them is a result too: an empty cloud.

    Attributes:
        cloud: with known poses in the world of the cameras given, with free poses in a frame and scale of its own, see
            ``avs.sfm.alignment.placed``.
        registered: names of the views that the cloud is made of, in the order given.
        left_out: why each of the other views is not among them, by name.
        cameras: for free poses those of ``registered``, as estimated, in the frame of the cloud; None for known poses.
        notes: what a reader of the numbers should know, such as a depth range that had to be guessed.
    """

    cloud: Cloud
    registered: tuple[str, ...]
    left_out: Mapping[str, str] = field(default_factory=dict)
    cameras: Cameras | None = None
    notes: tuple[str, ...] = ()


class BackEndSettings(StrictModel):
    """Base of the settings of a back end.

    A subclass narrows ``back_end`` to the literal name of its own, which is the field's default, narrows ``poses`` to
    what it can do, and adds fields.
    """

    back_end: str
    poses: Poses
    seed: Seed = Field(default=0, description="of every random choice")

    def lacks(self) -> Reason | None:
        """Return which file that the settings name, such as weights, is not there, and what helps; or None."""
        return None


class Reconstruct(Protocol):
    """The function of a back end."""

    def __call__(self, views: Views, settings: BackEndSettings, device: str) -> Reconstruction:
        """Return the cloud of ``views``; the same views, settings and device give the same bytes.

        Args:
            views: at least two, checked by ``check_views``.
            settings: of the back end, of its own type.
            device: ``cpu`` or ``cuda``, for networks.

        Raises:
            UserError: a package or weights are missing, or of another version.
        """
        ...


@dataclass(frozen=True)
class BackEnd:
    """One back end: ``BACK_END`` of the module of ``avs.sfm.back_ends`` that has its name. Read without its packages.

    Attributes:
        label: name for tables and figures.
        settings: the type of its settings.
        reconstruct: the function, as ``module:function``, imported when it is called.
        packages: the modules of other projects that it imports, with the remedy where one is not installed.
        source: where the method is published, one line.
        licence: terms of its code and weights, one line.
        versions: with which the versions of these projects must begin, by the name that pip knows them by; a project
            that is not installed by pip has none.
    """

    label: str
    settings: type[BackEndSettings]
    reconstruct: str
    packages: Mapping[str, str]
    source: str
    licence: str
    versions: Mapping[str, str] = field(default_factory=dict)

    @property
    def module(self) -> str:
        """The module with all of its code, for the rules of the workflow whose jobs reconstruct."""
        return self.reconstruct.partition(":")[0]


def check_views(views: Views, subject: object) -> None:
    """Refuse views that no back end could make a cloud of.

    Args:
        views: to be reconstructed.
        subject: what errors name, such as the episode they come from.

    Raises:
        UserError: there are fewer than two, a name is there twice, an image is no colour image of its camera's size, or
            the cameras stand in one place.
    """
    if len(views) < FEWEST:
        raise UserError(subject, f"has {len(views)} views", "structure from motion needs at least two")
    repeated = {name for name in views.names if views.names.count(name) > 1}
    if repeated:
        raise UserError(subject, f"view {min(repeated)} is there twice", "list each view once")
    for name, image, (width, height) in zip(views.names, views.images, views.cameras.sizes, strict=True):
        if image.dtype != np.uint8 or image.shape != (height, width, 3):
            fault = f"image {name} is {image.dtype} of shape {image.shape}, its camera has {width} x {height} pixels"
            raise UserError(subject, fault, "make the scene again")
    centers = views.cameras.centers
    if not np.ptp(centers, axis=0).max() > 1e-9 * np.abs(centers).max():
        raise UserError(subject, "all cameras stand in one place", "take photographs from different places")
