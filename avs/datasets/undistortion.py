"""From any of COLMAP's camera models to PINHOLE, without change of pixels where there is no distortion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from avs.scene.colmap import ModelCamera
from avs.scene.images import Pixels

if TYPE_CHECKING:
    import pycolmap

# Models that are a pinhole camera where the parameters after these are zero: number of focal lengths and coordinates of
# the principal point. A fisheye model is none, whatever its parameters.
_PINHOLE_PARAMETERS = {
    "SIMPLE_PINHOLE": 3,
    "PINHOLE": 4,
    "SIMPLE_RADIAL": 3,
    "RADIAL": 3,
    "OPENCV": 4,
    "FULL_OPENCV": 4,
}

_FARTHEST_CENTER = 10
"""Greatest coordinate of a principal point after undistortion, in sides of the image."""


def pinhole(camera: ModelCamera) -> ModelCamera | None:
    """Return ``camera`` as PINHOLE if it has no distortion, else None."""
    count = _PINHOLE_PARAMETERS.get(camera.model)
    if count is None or any(camera.params[count:]):
        return None
    focal_x, focal_y, center_x, center_y = (camera.params[0], *camera.params[:count])[-4:]
    return ModelCamera("PINHOLE", camera.width, camera.height, (focal_x, focal_y, center_x, center_y))


def rescaled(camera: ModelCamera, width: int, height: int) -> ModelCamera:
    """Return ``camera`` for images resized to ``width`` x ``height`` pixels."""
    converted = _to_pycolmap(camera)
    converted.rescale(width, height)
    return _from_pycolmap(converted)


def undistorted_camera(camera: ModelCamera) -> ModelCamera | None:
    """Return the PINHOLE camera of the undistorted images, or None where there is none, as of a panorama.

    Its size differs from that of ``camera``: as much of the image is kept as has no blank pixels.
    """
    import pycolmap

    try:
        result = pycolmap.undistort_camera(pycolmap.UndistortCameraOptions(), _to_pycolmap(camera))
    except ValueError:  # pycolmap's own check of the camera model
        return None
    straight = _from_pycolmap(result)
    if not np.isfinite(straight.params).all() or min(straight.width, straight.height) <= 1:
        return None
    return (
        straight if max(map(abs, straight.params[2:])) < _FARTHEST_CENTER * max(result.width, result.height) else None
    )


def undistorted_image(pixels: Pixels, camera: ModelCamera) -> Pixels:
    """Return the image that ``undistorted_camera(camera)`` sees, interpolated bilinearly.

    Args:
        pixels: ``[height, width, 3]`` uint8, of the size of ``camera``.
        camera: the camera that took it.
    """
    import pycolmap

    bitmap = pycolmap.Bitmap.from_array(np.ascontiguousarray(pixels))
    result, _ = pycolmap.undistort_image(pycolmap.UndistortCameraOptions(), bitmap, _to_pycolmap(camera))
    image: Pixels = result.to_array()
    return image


def projected(points: npt.NDArray[np.float64], camera: ModelCamera) -> npt.NDArray[np.float64]:
    """Return where ``camera`` sees ``points``, ``[n, 3]`` in its own axes: ``[n, 2]`` pixels, infinite for nowhere."""
    pixels = np.asarray(_to_pycolmap(camera).img_from_cam(points), dtype=np.float64)
    return np.where(np.isfinite(pixels), pixels, np.inf)


def _to_pycolmap(camera: ModelCamera) -> pycolmap.Camera:
    import pycolmap

    return pycolmap.Camera(
        model=camera.model, width=camera.width, height=camera.height, params=list(camera.params), camera_id=1
    )


def _from_pycolmap(camera: pycolmap.Camera) -> ModelCamera:
    return ModelCamera(camera.model_name, int(camera.width), int(camera.height), tuple(map(float, camera.params)))
