"""Photographs of a textured wall and floor whose geometry is known, for readers of poses without points."""

import functools

import cv2
import numpy as np

from avs.scene.cameras import look_at

SIZE = (240, 180)
FOCAL = (210.0, 214.0)
CENTER = (118.5, 92.0)  # COLMAP's pixel coordinates: the centre of the first pixel is (0.5, 0.5)
FLOOR = 0.8


@functools.cache
def texture():
    """Noise of three scales, so that features are found at every size, ``[512, 512, 3]`` uint8."""
    draw = np.random.default_rng(4)
    sizes = (16, 64, 256)
    noise = sum(cv2.resize(draw.random((side, side, 3)), (512, 512), interpolation=cv2.INTER_CUBIC) for side in sizes)
    return np.clip(noise / len(sizes) * 380 - 60, 0, 255).astype(np.uint8)


def poses(count=10):
    """World-to-camera matrices on an arc before the wall, the height changing, ``[count, 4, 4]``."""
    angles = np.linspace(-0.5, 0.5, count)
    centers = np.stack([3 * np.sin(angles), -0.4 + 0.3 * np.cos(7 * angles), -3 * np.cos(angles)], axis=1)
    return np.stack([look_at(center, np.array([0.0, 0.1, 0.0]), np.array([0.0, -1.0, 0.0])) for center in centers])


def photograph(pose, size=SIZE, focal=FOCAL, center=CENTER):
    """What a pinhole camera sees of the wall z = 0 and of the floor y = ``FLOOR`` before it, ``[h, w, 3]`` uint8."""
    columns, rows = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    local = np.stack([(columns - center[0]) / focal[0], (rows - center[1]) / focal[1], np.ones_like(rows)], axis=-1)
    rays, origin = local @ pose[:3, :3], -pose[:3, :3].T @ pose[:3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        wall, floor = -origin[2] / rays[..., 2], (FLOOR - origin[1]) / rays[..., 1]
    distance = np.minimum(np.where(wall > 0, wall, np.inf), np.where(floor > 0, floor, np.inf))
    x, y, z = np.moveaxis(origin + rays * distance[..., None], -1, 0)
    other = np.where(distance == floor, z + FLOOR, y)
    place = [((value + 3) * 512 / 6 % 512).astype(np.float32) for value in (x, other)]
    return cv2.remap(texture(), *place, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)


def assert_points_lie_on_the_surfaces(positions, tolerance):
    """Nearly all points are of the wall or the floor."""
    distances = np.minimum(np.abs(positions[:, 2]), np.abs(positions[:, 1] - FLOOR))
    assert len(positions) > 100
    assert np.quantile(distances, 0.9) < tolerance


def assert_poses_are(scene, expected, tolerance):
    """The scene's cameras, in the coordinates of the capture, stand and look as ``expected`` does."""
    np.testing.assert_allclose(
        scene.to_capture.points(scene.cameras.centers),
        [-pose[:3, :3].T @ pose[:3, 3] for pose in expected],
        atol=tolerance,
    )
    np.testing.assert_allclose(scene.cameras.world_to_camera[:, :3, :3], expected[:, :3, :3], atol=tolerance)
