"""The pose of a picture, found by gradients of the map's rendering through the rasteriser."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import Parameter

from avs.rasterizer.adam import Adam
from avs.scene.cameras import Cameras
from avs.slam.building.simulator import Frame
from avs.slam.mapping.gaussian_map import MapTensors, camera_tensors, map_rendering
from avs.slam.mapping.mapper_settings import TrackingSettings

_EPSILON = 1e-8
Matrix = npt.NDArray[np.float64]


def matrix_of(quaternion: Tensor, translation: Tensor) -> Tensor:
    """Return the ``[4, 4]`` transform of a quaternion ``[4]``, w first, any length but 0, and a translation ``[3]``."""
    w, x, y, z = torch.nn.functional.normalize(quaternion, dim=0)
    rows = [
        torch.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]),
        torch.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]),
        torch.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]),
    ]
    top = torch.cat([torch.stack(rows), translation[:, None]], dim=1)
    return torch.cat([top, torch.tensor([[0.0, 0.0, 0.0, 1.0]], dtype=top.dtype)])


def quaternion_of(rotation: Matrix) -> Matrix:
    """Return the quaternion ``[4]``, w first and not negative, of a rotation ``[3, 3]``."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat(canonical=True)
    return np.array([w, x, y, z])


def extrapolated(before: Matrix, last: Matrix) -> Matrix:
    """Return the world-to-camera transform ``[4, 4]`` that follows two others at constant velocity.

    As SplaTAM has it: quaternions and translations go on by their last difference, the former made unit length.
    """
    first, second = quaternion_of(before[:3, :3]), quaternion_of(last[:3, :3])
    if first @ second < 0:
        first = -first
    quaternion = torch.tensor(2 * second - first)
    translation = torch.tensor(2 * last[:3, 3] - before[:3, 3])
    return np.asarray(matrix_of(quaternion, translation).numpy(), np.float64)


def tracking_loss(
    tensors: MapTensors, viewmat: Tensor, camera: Cameras, frame: Frame, settings: TrackingSettings
) -> tuple[Tensor, float]:
    """Return the loss of a pose, and the part of it that is of depth.

    Sums over the pixels with a depth where the map is there (``silhouette``): absolute errors of depth, and of colours
    over all three channels. Which pixels count is not differentiated.
    """
    width, height = (int(side) for side in camera.sizes[0])
    fixed = {name: value.detach() for name, value in tensors.items()}
    seen = map_rendering(fixed, viewmat, camera_tensors(camera)[1], width, height)  # type: ignore[arg-type]
    depth, rgb = torch.from_numpy(frame.depth), torch.from_numpy(frame.rgb.astype(np.float32) / np.float32(255))
    counts = (depth > 0) & (seen.alpha.detach() > settings.silhouette)
    of_depth = (seen.depth - depth)[counts].abs().sum()
    of_color = (seen.rgb - rgb)[counts].abs().sum()
    return settings.depth_weight * of_depth + settings.color_weight * of_color, float(of_depth.detach())


def tracked(tensors: MapTensors, frame: Frame, guess: Cameras, settings: TrackingSettings) -> tuple[Cameras, float]:
    """Return the camera at the pose of the lowest loss on the way of Adam from ``guess``, and that loss.

    A pose that sees nothing of the map has no loss; the guess stays.
    """
    start = guess.world_to_camera[0]
    quaternion = Parameter(torch.tensor(quaternion_of(start[:3, :3]), dtype=torch.float32)[None])
    translation = Parameter(torch.tensor(start[:3, 3], dtype=torch.float32)[None])
    optimizers = (
        Adam(quaternion, settings.rotation_rate, _EPSILON),
        Adam(translation, settings.translation_rate, _EPSILON),
    )
    best, best_pose = np.inf, start
    rounds = 1 if settings.again_above is None else 2
    of_depth = np.inf
    for attempt in range(rounds):
        if attempt and of_depth < (settings.again_above or np.inf):
            break
        for _ in range(settings.iterations):
            viewmat = matrix_of(quaternion[0], translation[0])
            loss, of_depth = tracking_loss(tensors, viewmat, guess, frame, settings)
            value = float(loss.detach())
            if 0 < value < best:
                best, best_pose = value, viewmat.detach().numpy().astype(np.float64)
            if not loss.requires_grad:
                break
            loss.backward()  # type: ignore[no-untyped-call]
            for optimizer in optimizers:
                optimizer.step()
                optimizer.zero_grad()
    return replace(guess, world_to_camera=best_pose[None]), best
