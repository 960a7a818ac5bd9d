"""The mapper on a real clip or on a walk through a building, with given and with tracked poses.

Run by hand: ``python -m tests.benchmarks.slam_validation SOURCE [FRAMES]``, SOURCE being a folder in the layout of
7-Scenes (``frame-NNNNNN.color.jpg``, ``.depth.png``, ``.pose.txt``, ``camera-intrinsics.txt``) or a mesh. Every eighth
frame is held out of the map; PSNR and depth error are of those, the error of the trajectory is of all.
"""

from __future__ import annotations

import math
import sys
import time
from pathlib import Path

import numpy as np
import torch
from PIL import Image

from avs.scene.cameras import Cameras
from avs.slam.building.opened_building import open_simulator
from avs.slam.building.robot_camera import CameraSettings, Pose, camera_at
from avs.slam.building.simulator import Frame
from avs.slam.building.simulator_settings import SimulatorSettings
from avs.slam.evaluation.trajectory_error import absolute_trajectory_error
from avs.slam.mapping.gaussian_map import map_seen
from avs.slam.mapping.mapper import Mapper
from avs.slam.mapping.mapper_settings import KeyframeSettings, MapperSettings, TrackingSettings
from avs.slam.navigation.agent_settings import AgentSettings, MotionSettings
from avs.slam.navigation.floor_map import find_floor
from avs.slam.navigation.robot_motion import move, random_poses
from metrics.image import psnr

Clip = list[tuple[Frame, Cameras]]

FACTOR = 4
FIRST, HELD_OUT = 2, 8  # never a keyframe, which is every fourth
NONE = 65535


def recorded(folder: Path, count: int) -> Clip:
    """Return frames of a folder, a quarter as wide and high: colours averaged, depth of the middle pixel."""
    matrix = np.loadtxt(folder / "camera-intrinsics.txt") / FACTOR
    matrix[2, 2] = 1
    clip: Clip = []
    for path in sorted(folder.glob("*.pose.txt"))[:count]:
        stem = path.name.removesuffix(".pose.txt")
        with Image.open(folder / f"{stem}.color.jpg") as picture:
            size = (picture.width // FACTOR, picture.height // FACTOR)
            rgb = np.asarray(picture.resize(size, Image.Resampling.BOX), np.uint8)
        with Image.open(folder / f"{stem}.depth.png") as picture:
            millimetres = np.asarray(picture)[FACTOR // 2 :: FACTOR, FACTOR // 2 :: FACTOR]
        depth = np.where(millimetres == NONE, 0, millimetres).astype(np.float32) / np.float32(1000)
        pose = np.linalg.inv(np.loadtxt(path))
        clip.append((Frame(rgb, depth), Cameras(pose[None], matrix[None], np.array([size], np.int64))))
    return clip


def walked(mesh: Path, count: int) -> Clip:
    """Return frames of a walk by chance: forward, and a turn now and then, of one degree."""
    simulator = open_simulator(mesh, SimulatorSettings(samples=1))
    floor_map = find_floor(simulator.caster, simulator.building.box, AgentSettings(), mesh)
    rng = np.random.default_rng(1)
    pose: Pose = random_poses(floor_map, floor_map.islands == 0, 1, rng)[0]
    motion, camera = MotionSettings(forward=0.02, turn=1), CameraSettings(width=160, height=120)
    clip: Clip = []
    for k in range(count):
        at = camera_at(pose, camera)
        clip.append((simulator.observe(at), at))
        pose = move(floor_map, pose, "left" if k % 2 else "forward", motion).pose
    return clip


def held_out(mapper: Mapper, clip: Clip) -> tuple[float, float]:
    """Return PSNR and mean absolute error of depth, where there is one, over the held-out frames."""
    rows = []
    for number in range(FIRST, len(clip), HELD_OUT):
        frame, camera = clip[number]
        pose = mapper.poses[number][None]
        seen = map_seen(mapper.tensors, Cameras(pose, camera.intrinsics, camera.sizes))
        valid = frame.depth > 0
        error = np.abs(seen.depth.numpy() - frame.depth)[valid].mean()
        rows.append((psnr(seen.rgb.clamp(0, 1).numpy(), frame.rgb), error))
    decibels, error = np.mean(rows, axis=0)
    return float(decibels), float(error)


class HoldingOut(Mapper):
    """A mapper that finds the pose of every frame and maps all but the held-out ones."""

    def update(self, frame: Frame, camera: Cameras) -> None:
        """Map a frame that is not held out."""
        if (len(self.poses) - 1) % HELD_OUT != FIRST:
            super().update(frame, camera)


def main() -> None:
    """Map a clip twice and print what came out."""
    torch.set_num_threads(1)
    source, count = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 100
    clip = recorded(source, count) if source.is_dir() else walked(source, count)
    truth = np.array([camera.centers[0] for _, camera in clip])
    length = np.linalg.norm(np.diff(truth, axis=0), axis=1).sum()
    for name, tracking in (("given poses", None), ("tracked poses", TrackingSettings())):
        settings = MapperSettings(map_every=3, iterations=30, keyframes=KeyframeSettings(every=4), tracking=tracking)
        mapper, start = HoldingOut(settings, 0), time.process_time()
        for frame, camera in clip:
            mapper.add(frame, camera)
        decibels, error = held_out(mapper, clip)
        found = np.array([-pose[:3, :3].T @ pose[:3, 3] for pose in mapper.poses])
        trajectory = absolute_trajectory_error(found, truth)
        assert math.isfinite(trajectory)
        print(
            f"{source.name}, {len(clip)} frames over {length:.2f} m, {name}: PSNR {decibels:.2f} dB, depth error "
            f"{100 * error:.2f} cm, trajectory error {100 * trajectory:.2f} cm, "
            f"{len(mapper.tensors['means'])} Gaussians, {time.process_time() - start:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
