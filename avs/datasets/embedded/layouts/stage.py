"""What a layout hands to the camera: everything there is, its light, and where the subject stands."""

from __future__ import annotations

from dataclasses import dataclass

from avs.datasets.embedded.geometry.mesh_model import Mesh
from avs.datasets.embedded.light.light_sources import Lighting


@dataclass(frozen=True)
class Stage:
    """A scene before it is photographed.

    Attributes:
        meshes: all surfaces.
        lighting: all light.
        target: middle of the subject, metres.
        radius: metres from the target at which there is room for a camera.
        heading: direction, in radians about z, from which the subject is to be seen first.
        path: points of a walk, for scenes that are walked through; each ``(x, y)`` on the floor.
    """

    meshes: tuple[Mesh, ...]
    lighting: Lighting
    target: tuple[float, float, float]
    radius: float
    heading: float = 0.0
    path: tuple[tuple[float, float], ...] = ()
