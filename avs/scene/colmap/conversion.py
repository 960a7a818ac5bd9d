"""From cameras and points to a COLMAP model with PINHOLE cameras, and back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras
from avs.scene.colmap.model import NO_POINT, Model, ModelCamera, ModelImage
from avs.scene.points import Points


def as_model(names: Sequence[str], cameras: Cameras, points: Points) -> Model:
    """Return a model of n images whose keypoints are the projections of the observed points.

    Images that share intrinsics and size share one camera. Identifiers count from 1, in the order of the arguments.

    Raises:
        ValueError: an observed point lies behind its camera.
    """
    from scipy.spatial.transform import Rotation

    model_cameras: dict[ModelCamera, int] = {}
    images = {}
    for index, name in enumerate(names):
        matrix, transform = cameras.intrinsics[index], cameras.world_to_camera[index]
        params = (matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2])
        width, height = map(int, cameras.sizes[index])
        camera = ModelCamera("PINHOLE", width, height, tuple(map(float, params)))
        x, y, z, w = Rotation.from_matrix(transform[:3, :3]).as_quat(canonical=True)
        seen = np.sort(points.observations[points.observations[:, 1] == index, 0])
        local = points.positions[seen] @ transform[:3, :3].T + transform[:3, 3]
        if not (local[:, 2] > 0).all():
            raise ValueError(f"image {name} observes a point that lies behind its camera")
        keypoints = local[:, :2] / local[:, 2:] * params[:2] + params[2:]
        images[index + 1] = ModelImage(
            name=name,
            camera_id=model_cameras.setdefault(camera, len(model_cameras) + 1),
            quaternion=np.array([w, x, y, z]),
            translation=transform[:3, 3],
            keypoints=keypoints,
            points=seen + 1,
        )
    return Model(
        cameras={identifier: camera for camera, identifier in model_cameras.items()},
        images=images,
        point_ids=np.arange(1, len(points) + 1),
        positions=points.positions,
        colors=points.colors,
        errors=np.full(len(points), -1.0),
    )


def sorted_images(model: Model) -> list[ModelImage]:
    """Return the images in ascending order of name."""
    return sorted(model.images.values(), key=lambda image: image.name)


def cameras_of(model: Model) -> Cameras:
    """Return the cameras of the images, in ascending order of image name.

    Raises:
        ValueError: a camera is neither PINHOLE nor SIMPLE_PINHOLE.
    """
    images = sorted_images(model)
    transforms = np.tile(np.eye(4), (len(images), 1, 1))
    intrinsics = np.tile(np.eye(3), (len(images), 1, 1))
    sizes = np.zeros((len(images), 2), dtype=np.int64)
    for row, image in enumerate(images):
        camera = model.cameras[image.camera_id]
        if camera.model not in ("PINHOLE", "SIMPLE_PINHOLE"):
            raise ValueError(f"camera {image.camera_id} of image {image.name} is {camera.model}, not PINHOLE")
        focal_x, focal_y, center_x, center_y = (camera.params[0], *camera.params)[-4:]
        intrinsics[row, (0, 1, 0, 1), (0, 1, 2, 2)] = focal_x, focal_y, center_x, center_y
        transforms[row, :3, :3] = rotation_matrix(image.quaternion)
        transforms[row, :3, 3] = image.translation
        sizes[row] = camera.width, camera.height
    return Cameras(transforms, intrinsics, sizes)


def rotation_matrix(quaternion: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the rotation ``[3, 3]`` of a quaternion ``[4]``, w first, of any length but 0.

    It has the bits that ``scipy.spatial.transform`` gives, whose import takes longer than reading a scene.
    """
    w, x, y, z = quaternion
    length = np.sqrt(x * x + y * y + z * z + w * w)
    w, x, y, z = w / length, x / length, y / length, z / length
    return np.array(
        [
            [x * x - y * y - z * z + w * w, 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), -x * x + y * y - z * z + w * w, 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), -x * x - y * y + z * z + w * w],
        ]
    )


def points_of(model: Model) -> Points:
    """Return the points, in ascending order of identifier, observed by images in ascending order of name."""
    parts = [np.zeros((0, 2), dtype=np.int64)]
    for index, image in enumerate(sorted_images(model)):
        rows = np.searchsorted(model.point_ids, image.points[image.points != NO_POINT])
        parts.append(np.stack([rows, np.full(len(rows), index)], axis=1))
    return Points(model.positions, model.colors, np.unique(np.concatenate(parts), axis=0))
