"""Speed of active SLAM: frames of the simulator, iterations of mapper and tracker, decisions of each method.

Run by hand: ``python -m tests.benchmarks.bench_slam MESH``. Times are those of the processor, of one thread.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import torch

from avs.scene.cameras import Cameras
from avs.slam.building.opened_building import open_simulator
from avs.slam.building.robot_camera import CameraSettings, Pose, camera_at
from avs.slam.building.simulator import Simulator
from avs.slam.building.simulator_settings import SimulatorSettings
from avs.slam.exploration.frontiers import Candidate
from avs.slam.exploration.planned_paths import PlannedPath
from avs.slam.mapping.gaussian_map import empty_map
from avs.slam.mapping.keyframes import as_keyframe
from avs.slam.mapping.map_optimization import grown, lesson, optimised
from avs.slam.mapping.mapper_settings import GrowthSettings, MapperSettings, PruningSettings, TrackingSettings
from avs.slam.mapping.tracking import tracked
from avs.slam.navigation.agent_settings import AgentSettings
from avs.slam.navigation.floor_map import find_floor
from avs.slam.navigation.robot_motion import random_poses
from avs.slam.scoring.fisher_path_scorer import FisherPathScorer
from avs.slam.scoring.path_scorer import Moment
from avs.slam.scoring.path_settings import FisherPathSettings


def seconds(function: Callable[[], object], repeats: int) -> float:
    """Return the processor's seconds of one call, after one that is not counted."""
    function()
    start = time.process_time()
    for _ in range(repeats):
        function()
    return (time.process_time() - start) / repeats


def frames(simulator: Simulator, poses: list[Pose]) -> None:
    """Print frames per second."""
    for width, height in ((160, 120), (640, 480)):
        camera = CameraSettings(width=width, height=height)
        cameras = [camera_at(pose, camera) for pose in poses[:10]]
        spent = seconds(lambda cameras=cameras: [simulator.observe(each) for each in cameras], 1) / len(cameras)
        print(f"simulator, {width} x {height}: {1 / spent:.1f} frames/s")


def iterations(simulator: Simulator, poses: list[Pose]) -> None:
    """Print the times of mapper and tracker against the number of Gaussians."""
    camera = CameraSettings(width=160, height=120)
    tensors, seen = empty_map(), []
    rng = np.random.default_rng(0)
    settings = MapperSettings(iterations=20, pruning=PruningSettings(iterations=()))
    for target in (20_000, 50_000, 100_000, 200_000):
        for pose in poses:
            if len(tensors["means"]) >= target:
                break
            at = camera_at(pose, camera)
            frame = simulator.observe(at)
            tensors = grown(tensors, frame, at, GrowthSettings(), rng)
            seen.append((frame, at))
        lessons = [lesson(*each) for each in seen[-8:]]
        mapping = seconds(partial(optimised, tensors, lessons, settings, 10.0, rng), 2) / 20
        frame, at = seen[-1]
        tracking = seconds(partial(tracked, tensors, frame, at, TrackingSettings(iterations=20)), 2) / 20
        print(
            f"{len(tensors['means'])} Gaussians: mapper {1e3 * mapping:.1f}, tracker {1e3 * tracking:.1f} ms/iteration"
        )
    decision(tensors, [at for _, at in seen], simulator, poses, camera)


def decision(
    tensors: dict, cameras: list[Cameras], simulator: Simulator, poses: list[Pose], camera: CameraSettings
) -> None:
    """Print the time of FisherRF's decision at 64 candidates and 8 paths, with 16 keyframes."""
    candidates = [Candidate(pose, 0) for pose in poses[:64]]
    keyframes = [as_keyframe(k, simulator.observe(at), at) for k, at in enumerate(cameras[:16])]
    moment = Moment(poses[0], candidates, tensors, keyframes, camera, np.random.default_rng(0), 0)
    paths = [PlannedPath(k, ("forward",) * 30, tuple([poses[k]] * 30), 1.0) for k in range(8)]

    def decide() -> None:
        scorer = FisherPathScorer(FisherPathSettings())
        scorer.score(moment, scorer.shortlist(moment, 8), paths)

    print(f"FisherRF, {len(tensors['means'])} Gaussians: {seconds(decide, 1):.2f} s a decision")


def main() -> None:
    """Measure everything on one mesh."""
    torch.set_num_threads(1)
    path = Path(sys.argv[1])
    simulator = open_simulator(path, SimulatorSettings())
    floor_map = find_floor(simulator.caster, simulator.building.box, AgentSettings(), path)
    poses = random_poses(floor_map, floor_map.islands == 0, 400, np.random.default_rng(0))
    assert math.isfinite(poses[0].x)
    frames(simulator, poses)
    iterations(simulator, poses)


if __name__ == "__main__":
    main()
