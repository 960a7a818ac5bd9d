"""Poses that are tracked: their gradients, their first guess, and what is found."""

import math

import numpy as np
import pytest
import torch
from mapped_views import errors_of, view
from tolerances import SLAM_POSE_GRADIENT

from avs.slam.building.simulator import Frame
from avs.slam.mapping.mapper import Mapper
from avs.slam.mapping.mapper_settings import KeyframeSettings, MapperSettings, TrackingSettings
from avs.slam.mapping.tracking import extrapolated, matrix_of, quaternion_of, tracked, tracking_loss


def fitted_map(frames=((1.0, 1.5, 0.0),)):
    """Return a map of some views."""
    mapper = Mapper(MapperSettings(keyframes=KeyframeSettings(every=1)), 0)
    for x, y, yaw in frames:
        mapper.add(*view(x, y, yaw))
    return mapper.tensors


def test_quaternions_and_matrices_are_inverse():
    for yaw in np.linspace(-3, 3, 7):
        pose = view(yaw=yaw)[1].world_to_camera[0]
        back = matrix_of(torch.tensor(quaternion_of(pose[:3, :3])) * 3, torch.tensor(pose[:3, 3])).numpy()
        assert np.allclose(back, pose, atol=1e-12)


def test_constant_velocity_goes_on():
    a, b, c = (view(x=1.0 + 0.1 * k, yaw=0.05 * k)[1].world_to_camera[0] for k in range(3))
    # of a turning camera the translation of the transform bends a little: second order in the turn
    assert np.allclose(extrapolated(a, b), c, atol=0.02)
    straight = [view(x=1.0 + 0.1 * k)[1].world_to_camera[0] for k in range(3)]
    assert np.allclose(extrapolated(*straight[:2]), straight[2], atol=1e-12)


def test_gradients_of_the_pose_are_finite_differences():
    # Large blobs in the middle of the image and errors that keep their sign: the loss is smooth but for what it leaves
    # out at opacity 1/255.
    _, camera = view()
    draw = np.random.default_rng(0)
    means = np.array([3.0, 1.5, 1.25]) + draw.uniform(-0.4, 0.4, (40, 3))
    rows = {"means": means, "rgb": draw.uniform(0.2, 1, (40, 3)), "opacities": draw.uniform(-1, 1, 40)}
    rows["scales"] = np.log(draw.uniform(0.1, 0.2, (40, 1)))
    tensors = {name: torch.nn.Parameter(torch.tensor(value, dtype=torch.float32)) for name, value in rows.items()}
    depth = np.zeros((72, 96), np.float32)
    depth[30:42, 42:54] = 20.0  # where the blobs are sure to be; elsewhere no pixel counts
    far = Frame(np.full((72, 96, 3), 255, np.uint8), depth)
    settings = TrackingSettings(silhouette=0.0)
    start = camera.world_to_camera[0]

    def loss(numbers):
        return tracking_loss(tensors, matrix_of(numbers[:4], numbers[4:]), camera, far, settings)[0]

    numbers = np.concatenate([quaternion_of(start[:3, :3]), start[:3, 3]])
    leaf = torch.tensor(numbers, dtype=torch.float32, requires_grad=True)
    loss(leaf).backward()
    for k in range(7):
        step = np.zeros(7)
        step[k] = 2e-3
        ends = [loss(torch.tensor(numbers + sign * step, dtype=torch.float32)).item() for sign in (1, -1)]
        slope = (ends[0] - ends[1]) / 4e-3
        assert leaf.grad[k].item() == pytest.approx(slope, abs=SLAM_POSE_GRADIENT * leaf.grad.abs().max().item()), k


def test_tracking_finds_a_pose_that_was_moved():
    tensors = fitted_map(((1.0, 1.5, 0.0), (1.0, 1.4, 0.1), (1.1, 1.6, -0.1), (1.05, 1.5, 0.05)))
    frame, camera = view(1.03, 1.52, 0.02)
    guess = view(1.0, 1.5, 0.0)[1]
    found, loss = tracked(tensors, frame, guess, TrackingSettings(iterations=100))
    before = np.linalg.norm(guess.centers[0] - camera.centers[0])
    after = np.linalg.norm(found.centers[0] - camera.centers[0])
    assert after < 0.2 * before
    assert loss > 0


def test_tracking_without_anything_in_sight_keeps_the_guess():
    frame, guess = view(yaw=math.pi)
    found, _ = tracked(fitted_map(), frame, guess, TrackingSettings(iterations=3))
    assert np.allclose(found.world_to_camera, guess.world_to_camera)


def test_tracking_follows_a_turn():
    # A turn that 60 iterations at SplaTAM's rate of 4e-4 can reach: they move a quaternion by 0.024 at most.
    settings = MapperSettings(
        keyframes=KeyframeSettings(every=1), iterations=30, tracking=TrackingSettings(iterations=60)
    )
    mapper = errors_of(settings, turn=0.02)[2]
    truth = [view(1.0, 1.5, 0.02 * k)[1].centers[0] for k in range(8)]
    found = [-pose[:3, :3].T @ pose[:3, 3] for pose in mapper.poses]
    assert np.linalg.norm(np.array(found) - truth, axis=1).max() < 0.04
