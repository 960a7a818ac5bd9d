"""How a map renders a building from poses all over its floor, and how much of its surface it covers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras
from avs.slam.building.robot_camera import CameraSettings, Pose, camera_at
from avs.slam.building.simulator import Frame, Simulator
from avs.slam.evaluation.evaluation_settings import EvaluationSettings
from avs.slam.mapping.gaussian_map import MapTensors, map_seen, points_of
from metrics.coverage import nearest_distances, representatives, share_nearer
from metrics.image import psnr, ssim

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Quality:
    """Means over poses; see ``map_quality``.

    Attributes:
        depth_mae: metres.
        psnr: decibels.
        ssim: structural similarity.
        empty: share of the pixels where less than half is opaque.
        poses: how many were compared.
    """

    depth_mae: float
    psnr: float
    ssim: float
    empty: float
    poses: int


def map_quality(
    tensors: MapTensors,
    simulator: Simulator,
    poses: Sequence[Pose],
    camera: CameraSettings,
    settings: EvaluationSettings,
) -> Quality:
    """Compare renderings of a map with the truth at ``poses``, at least one.

    The depth error of a pose is the mean over all of its pixels, as in FisherRF's code: where the map is empty, depth
    is 0, and where the building has a hole the truth is 0. A rendering without any error counts as 100 dB.
    """
    rows = []
    for pose in poses:
        at = camera_at(pose, camera)
        truth, seen = simulator.observe(at), map_seen(tensors, at)
        alpha, depth = seen.alpha.numpy(), seen.depth.numpy()
        if settings.normalised:
            depth = np.where(alpha > 0, depth / np.maximum(alpha, 1e-6), 0)
        rgb = seen.rgb.clamp(0, 1).numpy()
        colors = psnr(rgb, truth.rgb), ssim(rgb, truth.rgb)
        rows.append((np.abs(depth - truth.depth).mean(), min(colors[0], 100.0), colors[1], (alpha < 0.5).mean()))
    error, decibels, similarity, empty = np.mean(rows, axis=0)
    return Quality(float(error), float(decibels), float(similarity), float(empty), len(rows))


def coverage_of(points: FloatArray, cloud: npt.NDArray[np.floating], threshold: float) -> float:
    """Return the share of surface ``points`` ``[n, 3]`` nearer to a cloud ``[m, 3]`` than ``threshold``, in 0..1."""
    return share_nearer(nearest_distances(points, cloud), threshold)


def fused_cloud(tensors: MapTensors, cameras: Sequence[Cameras], settings: EvaluationSettings) -> FloatArray:
    """Return the points ``[m, 3]`` of depth that the map renders at ``cameras``, one for each voxel.

    Depth is divided by the opacity, and used where that is above ``opacity``.
    """
    parts = [np.zeros((0, 3))]
    for camera in cameras:
        seen = map_seen(tensors, camera)
        alpha = seen.alpha.numpy()
        depth = seen.depth.numpy() / np.maximum(alpha, 1e-6)
        shown = Frame(np.zeros((*depth.shape, 3), np.uint8), depth)
        part = points_of(shown, camera, alpha > settings.opacity)
        parts.append(part[representatives(part, settings.voxel)])
    cloud = np.concatenate(parts)
    return cloud[representatives(cloud, settings.voxel)]
