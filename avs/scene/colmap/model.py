"""A COLMAP model in memory, and the checks that every reader shares."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from avs.system.errors import UserError

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]
PointArrays = tuple[IndexArray, FloatArray, npt.NDArray[np.uint8], FloatArray]

REMEDY = "copy the file again, or run the structure from motion again"

# Number in the binary form -> name and number of parameters.
CAMERA_MODELS = {
    0: ("SIMPLE_PINHOLE", 3),
    1: ("PINHOLE", 4),
    2: ("SIMPLE_RADIAL", 4),
    3: ("RADIAL", 5),
    4: ("OPENCV", 8),
    5: ("OPENCV_FISHEYE", 8),
    6: ("FULL_OPENCV", 12),
    7: ("FOV", 5),
    8: ("SIMPLE_RADIAL_FISHEYE", 4),
    9: ("RADIAL_FISHEYE", 5),
    10: ("THIN_PRISM_FISHEYE", 12),
    11: ("RAD_TAN_THIN_PRISM_FISHEYE", 16),
    12: ("SIMPLE_DIVISION", 4),
    13: ("DIVISION", 5),
    14: ("SIMPLE_FISHEYE", 3),
    15: ("FISHEYE", 4),
    16: ("EUCM", 6),
    17: ("EQUIRECTANGULAR", 2),
}
PARAMETERS = dict(CAMERA_MODELS.values())
NUMBERS = {name: number for number, (name, _) in CAMERA_MODELS.items()}
NO_POINT = -1


@dataclass(frozen=True)
class ModelCamera:
    """Intrinsics: COLMAP's name of the camera model, the image size in pixels, and the model's parameters."""

    model: str
    width: int
    height: int
    params: tuple[float, ...]


@dataclass(frozen=True)
class ModelImage:
    """A registered image.

    Attributes:
        name: path below ``images/``, with ``/``.
        camera_id: key of ``Model.cameras``.
        quaternion: ``[4]`` rotation from world to camera as w, x, y, z, of any positive length.
        translation: ``[3]`` from world to camera.
        keypoints: ``[k, 2]`` pixels.
        points: ``[k]`` identifier of the point each keypoint observes, -1 for none.
    """

    name: str
    camera_id: int
    quaternion: FloatArray
    translation: FloatArray
    keypoints: FloatArray
    points: IndexArray


@dataclass(frozen=True)
class Model:
    """A sparse model.

    Attributes:
        cameras: by identifier.
        images: by identifier.
        point_ids: ``[p]`` ascending identifiers of the points.
        positions: ``[p, 3]`` world coordinates.
        colors: ``[p, 3]`` uint8.
        errors: ``[p]`` mean reprojection error in pixels, -1 where unknown.
    """

    cameras: dict[int, ModelCamera]
    images: dict[int, ModelImage]
    point_ids: IndexArray = field(default_factory=lambda: np.zeros(0, np.int64))
    positions: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    colors: npt.NDArray[np.uint8] = field(default_factory=lambda: np.zeros((0, 3), np.uint8))
    errors: FloatArray = field(default_factory=lambda: np.zeros(0))


def point_arrays(rows: list[tuple[float, ...]]) -> PointArrays:
    """Sort rows of identifier, position, colour and error by identifier and split them into arrays."""
    rows.sort(key=lambda row: row[0])
    table = np.array([row[1:] for row in rows], dtype=np.float64).reshape(-1, 7)
    identifiers = np.array([row[0] for row in rows], dtype=np.int64)
    return identifiers, table[:, :3], table[:, 3:6].astype(np.uint8), table[:, 6]


def _focal_lengths(model: str) -> int:
    """Return how many focal lengths a camera model has; they are its first parameters."""
    return 1 if model.startswith(("SIMPLE_", "RADIAL")) else 2


def checked(folder: Path, suffix: str, model: Model) -> Model:
    """Return ``model`` if its numbers are usable and its parts fit one another."""
    images = folder / f"images{suffix}"
    for identifier, camera in model.cameras.items():
        if not all(map(math.isfinite, camera.params)) or camera.width < 1 or camera.height < 1:
            fault = f"camera {identifier} has a parameter that is not finite, or no size"
            raise UserError(folder / f"cameras{suffix}", fault, REMEDY)
        if min(camera.params[: _focal_lengths(camera.model)]) <= 0:
            fault = f"camera {identifier} has a focal length that is not positive"
            raise UserError(folder / f"cameras{suffix}", fault, REMEDY)
    names: set[str] = set()
    for image in model.images.values():
        pose = np.concatenate([image.quaternion, image.translation])
        if not np.isfinite(pose).all() or not np.any(image.quaternion):
            raise UserError(images, f"the pose of image {image.name} is not finite or has no rotation", REMEDY)
        if image.camera_id not in model.cameras:
            raise UserError(images, f"image {image.name} names camera {image.camera_id}, which does not exist", REMEDY)
        if image.name in names:
            raise UserError(images, f"image {image.name} occurs twice", REMEDY)
        names.add(image.name)
        if not np.isin(image.points[image.points != NO_POINT], model.point_ids).all():
            raise UserError(images, f"image {image.name} observes a point that does not exist", REMEDY)
    if not np.isfinite(model.positions).all():
        raise UserError(folder / f"points3D{suffix}", "a point's position is not finite", REMEDY)
    return model
