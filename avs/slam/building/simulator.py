"""What a colour and depth camera sees in a building, by casting rays at its mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.geometry.raycast import Caster
from avs.scene.cameras import Cameras
from avs.slam.building.building_mesh import Building, FloatArray
from avs.slam.building.surface_colors import SurfaceColors


@dataclass(frozen=True)
class Frame:
    """One picture of a colour and depth camera.

    Attributes:
        rgb: ``[height, width, 3]`` uint8 sRGB; black where there is no surface.
        depth: ``[height, width]`` float32 metres along the optical axis at the pixel centres; 0 where there is none.
    """

    rgb: npt.NDArray[np.uint8]
    depth: FloatArray


class Simulator:
    """A building to look at.

    Attributes:
        building: its mesh, in metres, z upwards.
        caster: casts rays at it.
        colors: of its surface.
    """

    def __init__(self, building: Building, samples: int = 2) -> None:
        """Prepare ``building``; colours are the mean of ``samples`` squared rays per pixel."""
        self.building = building
        self.caster = Caster(building.vertices, building.triangles)
        self.colors = SurfaceColors(building)
        self._samples = samples
        self._rays: dict[tuple[bytes, bytes, int], FloatArray] = {}

    def observe(self, camera: Cameras) -> Frame:
        """Return what one camera sees. Both sides of a wall without thickness are seen.

        Args:
            camera: a batch of one.
        """
        width, height = (int(side) for side in camera.sizes[0])
        depth, colors = self._cast(camera, 1)
        side = self._samples
        if side > 1:
            colors = self._cast(camera, side)[1].reshape(height, side, width, side, 3).mean(axis=(1, 3))
        rgb = np.rint(colors.reshape(height, width, 3) * 255).clip(0, 255).astype(np.uint8)
        return Frame(rgb, depth.reshape(height, width))

    def depth(self, camera: Cameras) -> FloatArray:
        """Return the depth ``[height, width]`` alone, which takes a fifth of the time."""
        width, height = (int(side) for side in camera.sizes[0])
        hits = self.caster.nearest(*self._directions(camera, 1))
        return np.where(hits.triangle >= 0, hits.distance, np.float32(0)).astype(np.float32).reshape(height, width)

    def _cast(self, camera: Cameras, side: int) -> tuple[FloatArray, FloatArray]:
        """Return depth ``[n]`` and colours ``[n, 3]`` on ``side`` squared points in each pixel, row by row."""
        hits = self.caster.nearest(*self._directions(camera, side))
        depth = np.where(hits.triangle >= 0, hits.distance, np.float32(0)).astype(np.float32)
        return depth, self.colors.at(hits.triangle, hits.weights)

    def _directions(self, camera: Cameras, side: int) -> tuple[FloatArray, FloatArray]:
        """Return the camera's centre ``[3]`` and its rays ``[n, 3]`` of depth one."""
        key = (camera.intrinsics[0].tobytes(), camera.sizes[0].tobytes(), side)
        if key not in self._rays:
            self._rays[key] = _local_rays(camera, side)
        rotation = camera.world_to_camera[0, :3, :3].astype(np.float32)
        return camera.centers[0].astype(np.float32), self._rays[key] @ rotation


def _local_rays(camera: Cameras, side: int) -> FloatArray:
    """Return the rays ``[height * side * width * side, 3]`` of depth one, in the camera's axes."""
    width, height = (int(length) * side for length in camera.sizes[0])
    rows, columns = np.meshgrid(np.arange(height), np.arange(width), indexing="ij")
    pixels = (np.stack([columns.ravel(), rows.ravel()], axis=1) + 0.5) / side
    matrix = camera.intrinsics[0]
    plane = (pixels - matrix[:2, 2]) / matrix[[0, 1], [0, 1]]
    return np.concatenate([plane, np.ones((len(plane), 1))], axis=1).astype(np.float32)
