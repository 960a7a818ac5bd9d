"""Keyframes: pictures kept in few bytes, and which of them see what the current one sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras
from avs.slam.building.simulator import Frame
from avs.slam.mapping.gaussian_map import points_of
from avs.slam.mapping.mapper_settings import KeyframeSettings

MILLIMETRE = 1000.0
_FARTHEST = 65535


@dataclass(frozen=True)
class Keyframe:
    """A picture with its pose: colours of 8 bits, depth in whole millimetres.

    Attributes:
        number: of the frame, from 0.
        camera: a batch of one.
        rgb: ``[height, width, 3]`` uint8.
        millimetres: ``[height, width]`` uint16 depth, 0 where there is none and beyond 65.5 m.
    """

    number: int
    camera: Cameras
    rgb: npt.NDArray[np.uint8]
    millimetres: npt.NDArray[np.uint16]

    @property
    def frame(self) -> Frame:
        """The picture, with depth in metres."""
        return Frame(self.rgb, (self.millimetres / np.float32(MILLIMETRE)).astype(np.float32))


def as_keyframe(number: int, frame: Frame, camera: Cameras) -> Keyframe:
    """Return a frame as it is kept."""
    millimetres = np.rint(frame.depth * MILLIMETRE)
    kept = np.where(millimetres <= _FARTHEST, millimetres, 0).astype(np.uint16)
    return Keyframe(number, camera, frame.rgb, kept)


def overlapping(
    frame: Frame, camera: Cameras, keyframes: list[Keyframe], settings: KeyframeSettings, rng: np.random.Generator
) -> list[int]:
    """Return the indices of the keyframes, ascending, in whose image some of the current picture's points fall.

    Depth plays no part: what a wall hides counts, as in SplaTAM.
    """
    valid = np.flatnonzero(frame.depth.ravel() > 0)
    if not len(valid):
        return []
    where = np.zeros(frame.depth.size, bool)
    where[rng.choice(valid, min(settings.samples, len(valid)), replace=False)] = True
    points = points_of(frame, camera, where.reshape(frame.depth.shape))
    return [index for index, keyframe in enumerate(keyframes) if _sees(keyframe.camera, points, settings.border)]


def _sees(camera: Cameras, points: npt.NDArray[np.float64], border: float) -> bool:
    pose, matrix = camera.world_to_camera[0], camera.intrinsics[0]
    local = points @ pose[:3, :3].T + pose[:3, 3]
    local = local[local[:, 2] > 0]
    pixels = local[:, :2] / local[:, 2:] * matrix[[0, 1], [0, 1]] + matrix[:2, 2]
    margin = border * camera.sizes[0, 0]
    return bool(((pixels > margin) & (pixels < camera.sizes[0] - margin)).all(axis=1).any())


def window_of(
    frame: Frame, camera: Cameras, keyframes: list[Keyframe], settings: KeyframeSettings, rng: np.random.Generator
) -> list[int]:
    """Return the keyframes beside the current picture that one optimisation uses, by index.

    The last one is always among them; the others are drawn among those that overlap.
    """
    if not keyframes or settings.window < 2:
        return []
    last = len(keyframes) - 1
    others = overlapping(frame, camera, keyframes[:last], settings, rng)
    count = min(settings.window - 2, len(others))
    drawn = rng.permutation(len(others))[:count]
    return [last, *(others[place] for place in drawn)]
