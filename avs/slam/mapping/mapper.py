"""The mapper: frames in, a map of Gaussians out; saved and resumed to the bit."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from avs.scene.cameras import Cameras
from avs.slam.building.simulator import Frame
from avs.slam.mapping.gaussian_map import MapTensors, empty_map
from avs.slam.mapping.keyframes import Keyframe, as_keyframe, window_of
from avs.slam.mapping.map_optimization import grown, lesson, optimised
from avs.slam.mapping.mapper_settings import MapperSettings
from avs.slam.mapping.tracking import extrapolated, tracked

_RADIUS = 3.0


class Mapper:
    """SplaTAM's loop over frames.

    Attributes:
        settings: of the mapper.
        tensors: the map.
        keyframes: the pictures that it is optimised on.
        poses: world-to-camera transforms ``[4, 4]`` of all frames so far, given or found.
        rng: of every random choice.
        radius: of the scene, a third of the greatest depth of the first frame, metres; 0 before it.
        seconds: spent on tracking and on mapping so far.
    """

    def __init__(self, settings: MapperSettings, seed: int) -> None:
        """Start without a map."""
        self.settings = settings
        self.tensors: MapTensors = empty_map()
        self.keyframes: list[Keyframe] = []
        self.poses: list[np.ndarray[tuple[int, int], np.dtype[np.float64]]] = []
        self.rng = np.random.Generator(np.random.PCG64(seed))
        self.radius = 0.0
        self.seconds = {"track": 0.0, "map": 0.0}

    def add(self, frame: Frame, camera: Cameras) -> None:
        """Take the next frame.

        Args:
            frame: what was seen.
            camera: the true one where poses are given; else only its intrinsics and, for the first frame, its pose.
        """
        number, start = len(self.poses), time.perf_counter()
        if self.settings.tracking is not None and number > 0:
            camera, _ = tracked(self.tensors, frame, self._guess(camera), self.settings.tracking)
        self.poses.append(camera.world_to_camera[0].copy())
        self.seconds["track"] += time.perf_counter() - start
        start = time.perf_counter()
        if not number:
            self.radius = float(frame.depth.max()) / _RADIUS
        if number % self.settings.map_every == 0:
            self.update(frame, camera)
        if number % self.settings.keyframes.every == 0:
            self.keyframes.append(as_keyframe(number, frame, camera))
        self.seconds["map"] += time.perf_counter() - start

    def update(self, frame: Frame, camera: Cameras) -> None:
        """Let the map grow by a frame, and optimise it."""
        settings = self.settings
        if not self.radius:
            self.radius = float(frame.depth.max()) / _RADIUS
        self.tensors = grown(self.tensors, frame, camera, settings.growth, self.rng)
        if not len(self.tensors["means"]):
            return
        window = window_of(frame, camera, self.keyframes, settings.keyframes, self.rng)
        lessons = [lesson(frame, camera)]
        lessons += [lesson(self.keyframes[index].frame, self.keyframes[index].camera) for index in window]
        self.tensors, _ = optimised(self.tensors, lessons, settings, self.radius, self.rng)

    def _guess(self, camera: Cameras) -> Cameras:
        last = self.poses[-1]
        guess = last if len(self.poses) < 2 else extrapolated(self.poses[-2], last)
        return replace(camera, world_to_camera=guess[None])
