"""Files of cameras in nerfstudio's form, ``transforms.json``: intrinsics and camera-to-world poses of listed pictures.

Programs agree on the shape of the file and not on what it means: the camera's axes are OpenGL's or OpenCV's, and the
principal point counts from the corner of the first pixel or from its centre. The file says neither, so the user does.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from avs.scene.cameras import FloatArray
from avs.scene.colmap import Model, ModelCamera, ModelImage
from avs.scene.colmap.model import check_camera, check_pose
from avs.system.errors import UserError
from avs.system.models import first_fault
from avs.system.regular_files import check_regular

Axes = Literal["opengl", "opencv"]
PixelCenters = Literal["half", "integer"]

REMEDY = "export the capture again"

_PERSPECTIVE = (None, "OPENCV", "FULL_OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "RADIAL", "SIMPLE_RADIAL", "linear")
_RIGID = 1e-3
"""How far a rotation may be from one, in any entry of R times its transpose."""

_Row = Annotated[list[float], Field(min_length=4, max_length=4)]


class _Told(BaseModel):
    """What a frame says, or the file for all frames that do not. Other keys are not read."""

    model_config = ConfigDict(extra="ignore", frozen=True, allow_inf_nan=False)

    camera_model: str | None = None
    is_fisheye: bool = False
    fl_x: float | None = None
    fl_y: float | None = None
    fx: float | None = None
    fy: float | None = None
    camera_angle_x: float | None = None
    cx: float | None = None
    cy: float | None = None
    w: float | None = None
    h: float | None = None
    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    k4: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    distortion_params: list[float] = Field(default_factory=list)


class _Frame(_Told):
    file_path: str | None = None
    image_path: str | None = None
    transform_matrix: list[_Row] = Field(min_length=3, max_length=4)


class _File(_Told):
    frames: list[_Frame] = Field(min_length=1)
    ply_file_path: str | None = None


@dataclass(frozen=True)
class Transforms:
    """What a file of cameras tells.

    Attributes:
        path: the file.
        frames: each picture's name below the file's folder, and what is told of it.
        points: path of the cloud that it names, or None.
    """

    path: Path
    frames: tuple[tuple[str, _Frame], ...]
    points: Path | None


def read_transforms(path: Path) -> Transforms:
    """Read a file of cameras.

    Raises:
        UserError: it is missing or damaged, lists a picture twice, or one outside of its folder.
    """
    file = _read(path)
    shared = file.model_dump(exclude={"frames", "ply_file_path"}, exclude_unset=True)
    frames: dict[str, _Frame] = {}
    for number, own in enumerate(file.frames):
        name = own.file_path or own.image_path
        if not name:
            raise UserError(path, f"frames.{number} has neither file_path nor image_path", REMEDY)
        name = _name_of(path, name)
        if name in frames:
            raise UserError(path, f"lists the picture {name} twice", "take one of the two out of frames")
        told = own.model_dump(exclude_unset=True)
        frames[name] = _Frame.model_validate(_without_those_of(told, shared) | told)
    points = None if file.ply_file_path is None else path.parent / _name_of(path, file.ply_file_path)
    return Transforms(path, tuple(frames.items()), points)


_ALTERNATIVES = (("fl_x", "fx", "camera_angle_x"), ("fl_y", "fy"), ("camera_model", "is_fisheye"))
"""Keys that tell the same under several names: a frame's own goes before the file's, whichever of them it is."""


def _without_those_of(own: dict[str, object], shared: dict[str, object]) -> dict[str, object]:
    """Return what the file says for all frames, less what a frame says under another name."""
    replaced = {key for keys in _ALTERNATIVES if not own.keys().isdisjoint(keys) for key in keys}
    return {key: value for key, value in shared.items() if key not in replaced}


def model_of(transforms: Transforms, sizes: dict[str, tuple[int, int]], axes: Axes, centers: PixelCenters) -> Model:
    """Return cameras and poses, without points.

    Args:
        transforms: the file.
        sizes: width and height of each picture, by name; they count where the file states no size.
        axes: of the cameras: ``opengl`` (x right, y up, z backwards) or ``opencv`` (x right, y down, z forwards).
        centers: where the centre of the first pixel is: at (0.5, 0.5), ``half``, or at (0, 0), ``integer``.

    Raises:
        UserError: numbers are missing or cannot be those of a camera or a pose.
    """
    cameras: dict[ModelCamera, int] = {}
    images = {}
    for number, (name, frame) in enumerate(transforms.frames, 1):
        camera = _camera(transforms.path, name, frame, sizes[name], 0.5 if centers == "integer" else 0.0)
        identifier = cameras.setdefault(camera, len(cameras) + 1)
        check_camera(transforms.path, identifier, camera)
        images[number] = posed_image(
            transforms.path, name, identifier, _world_to_camera(transforms.path, name, frame, axes)
        )
    return Model({identifier: camera for camera, identifier in cameras.items()}, images)


def posed_image(path: Path, name: str, camera: int, world_to_camera: FloatArray) -> ModelImage:
    """Return an image that observes no point.

    Args:
        path: the file that the pose is from, for messages.
        name: of the image.
        camera: identifier of its camera.
        world_to_camera: ``[4, 4]``, a rotation and a translation.

    Raises:
        UserError: the pose is none.
    """
    from scipy.spatial.transform import Rotation

    rotation = world_to_camera[:3, :3]
    if not np.isfinite(world_to_camera).all():
        raise UserError(path, f"the pose of {name} is not finite", REMEDY)
    if not (np.abs(rotation @ rotation.T - np.eye(3)) < _RIGID).all() or np.linalg.det(rotation) < 0:
        raise UserError(path, f"the pose of {name} has no rotation, but a matrix that scales or mirrors", REMEDY)
    x, y, z, w = Rotation.from_matrix(rotation).as_quat(canonical=True)
    image = ModelImage(
        name=name,
        camera_id=camera,
        quaternion=np.array([w, x, y, z]),
        translation=world_to_camera[:3, 3],
        keypoints=np.zeros((0, 2)),
        points=np.zeros(0, dtype=np.int64),
    )
    check_pose(path, image)
    return image


def _read(path: Path) -> _File:
    if not path.is_file():
        check_regular(path) if path.exists() else None
        raise UserError(path, "is missing", "copy the whole folder that the export wrote")
    try:
        return _File.model_validate(json.loads(path.read_text(encoding="utf-8-sig")))
    except ValidationError as error:
        place, fault = first_fault(error)
        raise UserError(path, f"{place or 'the file'}: {fault}", REMEDY) from None
    except (ValueError, RecursionError) as error:  # no JSON, or no text
        raise UserError(path, "is damaged or cut off: it is no JSON", "copy the file again") from error


def _name_of(path: Path, told: str) -> str:
    """Return a file's path below the folder of ``path``; one that is absolute, as of another machine, by its name."""
    folder, named = path.parent, Path(told.replace("\\", "/"))
    if "\0" in told:
        raise UserError(path, f"{told} is no name of a file", REMEDY)
    if named.is_absolute():
        named = named.relative_to(folder) if named.is_relative_to(folder) else Path(named.name)
    if ".." in named.parts or not named.name:
        raise UserError(path, f"{told} lies outside of its folder", "move the file to where the pictures are")
    if not named.suffix:  # as in the form of NeRF's synthetic scenes
        found = [
            named.with_suffix(suffix)
            for suffix in (".png", ".jpg", ".JPG")
            if (folder / named).with_suffix(suffix).is_file()
        ]
        named = found[0] if found else named
    return named.as_posix()


def _camera(path: Path, name: str, frame: _Frame, size: tuple[int, int], shift: float) -> ModelCamera:
    """Return the camera of a frame; ``shift`` is added to its principal point."""
    stated = frame.w is not None and frame.h is not None
    if (frame.w is None) != (frame.h is None):
        raise UserError(path, f"states one of w and h alone for {name}", "state both, or neither")
    width, height = (round(frame.w or 0), round(frame.h or 0)) if stated else size
    focal = frame.fx if frame.fl_x is None else frame.fl_x
    vertical = frame.fy if frame.fl_y is None else frame.fl_y
    if focal is None and frame.camera_angle_x is not None and 0 < frame.camera_angle_x < math.pi:
        focal = width / 2 / math.tan(frame.camera_angle_x / 2)
    if focal is None:
        raise UserError(path, f"states no focal length for {name}: fl_x, fx or camera_angle_x", REMEDY)
    center_x = width / 2 if frame.cx is None else frame.cx + shift
    center_y = height / 2 if frame.cy is None else frame.cy + shift
    if not stated and not (0 < center_x < width and 0 < center_y < height):
        fault = f"the principal point ({center_x:g}, {center_y:g}) lies outside of {name}, {width} x {height} pixels"
        raise UserError(path, fault, "state in w and h the size that the intrinsics are of")
    model, distortion = _distortion(path, name, frame)
    parameters = (focal, focal if vertical is None else vertical, center_x, center_y, *distortion)
    return ModelCamera(model, width, height, parameters)


def _distortion(path: Path, name: str, frame: _Frame) -> tuple[str, tuple[float, ...]]:
    """Return COLMAP's name of a camera's model, and its parameters after the principal point."""
    radial, tangential, others = (frame.k1, frame.k2), (frame.p1, frame.p2), tuple(frame.distortion_params)
    if frame.camera_model == "FISHEYE624" and len(others) == 12:  # Aria's own camera model
        return "RAD_TAN_THIN_PRISM_FISHEYE", others
    # instant-ngp says it by a key of its own
    fisheye = frame.camera_model == "OPENCV_FISHEYE" or (frame.is_fisheye and frame.camera_model in _PERSPECTIVE)
    if fisheye and not any((*tangential, *others)):
        return "OPENCV_FISHEYE", (*radial, frame.k3, frame.k4)
    if frame.camera_model in _PERSPECTIVE and not fisheye and not frame.k4 and not any(others):
        if frame.k3:
            return "FULL_OPENCV", (*radial, *tangential, frame.k3, 0.0, 0.0, 0.0)
        return ("OPENCV", (*radial, *tangential)) if any((*radial, *tangential)) else ("PINHOLE", ())
    fault = f"the camera {frame.camera_model} of {name}, with its parameters, cannot be undistorted"
    raise UserError(path, fault, "rectify the pictures first, or export a perspective or fisheye camera")


def _world_to_camera(path: Path, name: str, frame: _Frame, axes: Axes) -> FloatArray:
    """Return the inverse of a frame's pose, ``[4, 4]``, in OpenCV axes."""
    pose = np.eye(4)
    pose[:3] = frame.transform_matrix[:3]
    if not pose[:3, :3].any():
        raise UserError(path, f"the pose of {name} is all zero", "take the frame out, or get its pose")
    if axes == "opengl":
        pose[:, 1:3] *= -1
    inverse = np.eye(4)
    inverse[:3, :3] = pose[:3, :3].T
    inverse[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return inverse
