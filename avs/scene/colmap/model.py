"""A COLMAP model in memory, and the checks that every reader shares."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from avs.system.errors import UserError

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]
PointArrays = tuple[IndexArray, FloatArray, npt.NDArray[np.uint8], FloatArray]

Record = TypeVar("Record")

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
"""In the binary form this is 2^64 - 1, as an unsigned number; some programs write it so in the text form too."""

_LONGEST_SIDE = 1 << 20
"""Pixels of a camera's side: no image file that is read has more."""

_FARTHEST = 1e15
"""Greatest coordinate: more than light-years in millimetres, and the squares still are numbers."""

_FARTHEST_CENTER = 10
"""Greatest coordinate of a principal point, in sides of the image; images cut from a larger one have it outside."""

_STRONGEST_DISTORTION = 1e6
"""Greatest coefficient: that of long lenses are large, since they belong to high powers of small angles."""

_UNIT = 1e-3
"""How far the length of a quaternion may be from 1; one damaged number mostly makes it differ by more."""


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
        quaternion: ``[4]`` rotation from world to camera as w, x, y, z, of length 1.
        translation: ``[3]`` from world to camera.
        keypoints: ``[k, 2]`` pixels.
        points: ``[k]`` identifier of the point each keypoint observes, ``NO_POINT`` for none.
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
        dropped: number of observations that were left out, because the model lacks the point they are of, as after the
            cloud alone was cleaned.
    """

    cameras: dict[int, ModelCamera]
    images: dict[int, ModelImage]
    point_ids: IndexArray = field(default_factory=lambda: np.zeros(0, np.int64))
    positions: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    colors: npt.NDArray[np.uint8] = field(default_factory=lambda: np.zeros((0, 3), np.uint8))
    errors: FloatArray = field(default_factory=lambda: np.zeros(0))
    dropped: int = 0


def put(records: dict[int, Record], path: Path, kind: str, identifier: int, record: Record) -> None:
    """Add a record that was read to ``records``.

    Raises:
        UserError: there is one of that identifier.
    """
    if identifier in records:
        raise UserError(path, f"is damaged: the {kind} {identifier} occurs twice", REMEDY)
    records[identifier] = record


def point_arrays(path: Path, rows: list[tuple[float, ...]]) -> PointArrays:
    """Sort rows of identifier, position, colour and error by identifier and split them into arrays.

    Raises:
        UserError: an identifier occurs twice or is out of range, or a colour is.
    """
    rows.sort(key=lambda row: row[0])
    if rows and not 0 <= rows[0][0] <= rows[-1][0] < 1 << 63:
        raise UserError(path, "is damaged: the identifier of a point is below 0 or takes more than 63 bits", REMEDY)
    identifiers = np.array([row[0] for row in rows], dtype=np.int64)
    repeated = identifiers[1:][np.diff(identifiers) == 0]
    if len(repeated):
        raise UserError(path, f"is damaged: the point {repeated[0]} occurs twice", REMEDY)
    table = np.array([row[1:] for row in rows], dtype=np.float64).reshape(-1, 7)
    if not ((table[:, 3:6] >= 0) & (table[:, 3:6] <= 255)).all():
        raise UserError(path, "is damaged: a colour is not in 0 to 255", REMEDY)
    return identifiers, table[:, :3], table[:, 3:6].astype(np.uint8), table[:, 6]


def checked(folder: Path, suffix: str, model: Model) -> Model:
    """Return ``model``, without observations of points that it lacks, if its numbers are usable and its parts fit."""
    for identifier, camera in model.cameras.items():
        check_camera(folder / f"cameras{suffix}", identifier, camera)
    images = folder / f"images{suffix}"
    names: set[str] = set()
    for image in model.images.values():
        check_pose(images, image)
        if image.camera_id not in model.cameras:
            raise UserError(images, f"image {image.name} names camera {image.camera_id}, which does not exist", REMEDY)
        if image.name in names:
            raise UserError(images, f"image {image.name} occurs twice", REMEDY)
        names.add(image.name)
    if not (np.abs(model.positions) <= _FARTHEST).all():
        raise UserError(folder / f"points3D{suffix}", f"a point's position is not finite or beyond {_FARTHEST}", REMEDY)
    return _without_lost_points(model)


def check_camera(path: Path, identifier: int, camera: ModelCamera) -> None:
    """Raise a ``UserError`` that names ``path`` if the numbers of a camera cannot be those of one."""
    if not all(map(math.isfinite, camera.params)) or camera.width < 1 or camera.height < 1:
        raise UserError(path, f"camera {identifier} has a parameter that is not finite, or no size", REMEDY)
    if max(camera.width, camera.height) > _LONGEST_SIDE:
        raise UserError(path, f"camera {identifier} has sides of more than {_LONGEST_SIDE} pixels", REMEDY)
    focal_lengths = camera.params[: _focal_lengths(camera.model)]
    if min(focal_lengths) <= 0:
        raise UserError(path, f"camera {identifier} has a focal length that is not positive", REMEDY)
    side = max(camera.width, camera.height)
    if not all(side / 1e4 < value < side * 1e6 for value in focal_lengths):
        fault = f"camera {identifier} has a focal length of {max(focal_lengths):g} pixels for images of {side}"
        raise UserError(path, fault, REMEDY)
    others = camera.params[_focal_lengths(camera.model) :]
    if any(abs(value) > _FARTHEST_CENTER * side for value in others[:2]):
        raise UserError(path, f"camera {identifier} has its principal point far outside of the image", REMEDY)
    if any(abs(value) > _STRONGEST_DISTORTION for value in others[2:]):
        fault = f"camera {identifier} has a distortion of {max(map(abs, others[2:])):g}"
        raise UserError(path, fault, REMEDY)


def _focal_lengths(model: str) -> int:
    """Return how many focal lengths a camera model has; they are its first parameters."""
    return 1 if model.startswith(("SIMPLE_", "RADIAL")) else 2


def check_pose(path: Path, image: ModelImage) -> None:
    """Raise a ``UserError`` that names ``path`` if the pose of an image is none."""
    pose = np.concatenate([image.quaternion, image.translation])
    if not np.isfinite(pose).all() or not np.any(image.quaternion):
        raise UserError(path, f"the pose of image {image.name} is not finite or has no rotation", REMEDY)
    length = math.hypot(*image.quaternion)
    if abs(length - 1) > _UNIT:
        fault = f"the quaternion of image {image.name} has the length {length:.4g}, not 1"
        raise UserError(path, fault, f"{REMEDY}, or scale it to 1 if it is right")
    if np.abs(image.translation).max() > _FARTHEST:
        raise UserError(path, f"the pose of image {image.name} lies beyond {_FARTHEST}", REMEDY)


def _without_lost_points(model: Model) -> Model:
    """Return ``model`` without observations of points that it does not have; ``Model.dropped`` counts them."""
    images, dropped = {}, 0
    for identifier, image in model.images.items():
        lost = (image.points != NO_POINT) & ~np.isin(image.points, model.point_ids)
        dropped += int(lost.sum())
        kept = replace(image, points=np.where(lost, NO_POINT, image.points)) if lost.any() else image
        images[identifier] = kept
    return replace(model, images=images, dropped=dropped) if dropped else model
