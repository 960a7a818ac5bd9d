"""Small captures in COLMAP layout, written by pycolmap, with dots drawn where the points are seen."""

import numpy as np
import pycolmap
from PIL import Image

from avs.scene.cameras import look_at

# Distortion of normalised image coordinates, written down here once more so that the tests do not depend on pycolmap's.
SIMPLE_RADIAL = {"model": "SIMPLE_RADIAL", "params": [150.0, 80.5, 59.5, 0.3]}
OPENCV = {"model": "OPENCV", "params": [150.0, 155.0, 81.0, 60.0, 0.25, -0.1, 0.004, -0.003]}
PINHOLE = {"model": "PINHOLE", "params": [150.0, 155.0, 81.0, 60.0]}
SIZE = (160, 120)

POINTS = np.stack([*np.meshgrid(np.linspace(-0.9, 0.9, 4), np.linspace(-0.6, 0.6, 3)), np.zeros((3, 4))], axis=-1)
POINTS = POINTS.reshape(-1, 3)


def transforms(count):
    """Cameras on an arc above the points."""
    angles = np.linspace(-0.4, 0.4, count)
    centers = np.stack([3 * np.sin(angles), 0.2 * np.cos(9 * angles), -3 * np.cos(angles)], axis=1)
    return [look_at(center, np.zeros(3), np.array([0.0, -1.0, 0.0])) for center in centers]


def project(transform, camera, points=POINTS):
    """Pixel coordinates of ``points``, with distortion, ``[p, 2]``."""
    local = points @ transform[:3, :3].T + transform[:3, 3]
    x, y = (local[:, :2] / local[:, 2:]).T
    square = x * x + y * y
    if camera["model"] == "SIMPLE_RADIAL":
        focal, center_x, center_y, k = camera["params"]
        return np.stack([focal * x * (1 + k * square) + center_x, focal * y * (1 + k * square) + center_y], axis=1)
    focal_x, focal_y, center_x, center_y, k1, k2, p1, p2 = [*camera["params"], 0, 0, 0, 0][:8]
    radial = 1 + k1 * square + k2 * square**2
    bent_x = x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x)
    bent_y = y * radial + 2 * p2 * x * y + p1 * (square + 2 * y * y)
    return np.stack([focal_x * bent_x + center_x, focal_y * bent_y + center_y], axis=1)


def dots(size, pixels, radius=2.0):
    """An image with a soft white dot at each of ``pixels``, whose centroid is exact to a hundredth of a pixel."""
    columns, rows = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    light = sum(np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2 * radius**2)) for x, y in pixels)
    return np.repeat(np.round(20 + 220 * np.clip(light, 0, 1)).astype(np.uint8)[..., None], 3, axis=2)


def centroid(image, pixel, window=7):
    """Centroid of the dot near ``pixel`` in ``image``, in pixels."""
    column, row = (int(value) for value in pixel)
    top, left = max(row - window, 0), max(column - window, 0)
    patch = image[top : row + window + 1, left : column + window + 1, 0].astype(float) - 20
    patch[patch < 10] = 0
    rows, columns = np.mgrid[: patch.shape[0], : patch.shape[1]] + 0.5
    return np.array([(patch * columns).sum(), (patch * rows).sum()]) / patch.sum() + [left, top]


def make_capture(folder, cameras=(PINHOLE,), names=None, count=9, sizes=(SIZE,), text=False, points=True):
    """Write a capture; image i has camera i modulo their number. Return the transforms."""
    names = names or [f"image {i}.png" for i in range(count)]
    model = pycolmap.Reconstruction()
    for number, camera in enumerate(cameras):
        width, height = sizes[number % len(sizes)]
        model.add_camera_with_trivial_rig(pycolmap.Camera(camera_id=number + 1, width=width, height=height, **camera))
    poses = transforms(len(names))
    for index, (name, transform) in enumerate(zip(names, poses, strict=True)):
        camera, size = cameras[index % len(cameras)], sizes[index % len(cameras) % len(sizes)]
        pixels = project(transform, camera)
        keypoints = pixels if points else pixels[:0]
        image = pycolmap.Image(name=name, keypoints=keypoints, camera_id=index % len(cameras) + 1, image_id=index + 1)
        model.add_image_with_trivial_frame(image, pycolmap.Rigid3d(transform[:3]))
        path = folder / "images" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(dots(size, pixels)).save(path)
    for row, position in enumerate(POINTS if points else []):
        track = pycolmap.Track([pycolmap.TrackElement(index + 1, row) for index in range(len(names))])
        model.add_point3D(position, track, np.array([200, 100, row], np.uint8))
    (folder / "sparse" / "0").mkdir(parents=True)
    (model.write_text if text else model.write)(folder / "sparse" / "0")
    return poses
