"""The text form of COLMAP models, ``.txt``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avs.scene.colmap.model import NO_POINT, PARAMETERS, REMEDY, ModelCamera, ModelImage, PointArrays, point_arrays, put
from avs.system.errors import UserError


def read_cameras(path: Path) -> dict[int, ModelCamera]:
    """Read ``cameras.txt``: cameras by identifier."""
    cameras: dict[int, ModelCamera] = {}
    for line in filter(_is_record, _lines(path)):
        try:
            identifier, model, width, height, *params = line.split()
            camera = ModelCamera(model, int(width), int(height), tuple(map(float, params)))
            key = int(identifier)
        except (ValueError, OverflowError) as error:
            raise _fault(path, line) from error
        if camera.model not in PARAMETERS:
            fault = f"camera {identifier} has the unknown camera model {model}"
            raise UserError(path, fault, "write the model with a known one, such as OPENCV")
        if len(params) != PARAMETERS[model]:
            raise _fault(path, line)
        put(cameras, path, "camera", key, camera)
    return cameras


def read_images(path: Path) -> dict[int, ModelImage]:
    """Read ``images.txt``: images by identifier."""
    images: dict[int, ModelImage] = {}
    lines = iter(_lines(path))
    for line in lines:
        if not _is_record(line):
            continue
        keypoints = next(lines, "")
        try:
            identifier, *pose, camera_id, name = line.split(maxsplit=9)
            numbers = np.array(pose, dtype=np.float64).reshape(7)
            fields = keypoints.split()
            table = np.array(fields, dtype=np.float64).reshape(-1, 3)
            points = np.array([_point(field) for field in fields[2::3]], dtype=np.int64)
            key, camera = int(identifier), int(camera_id)
        except (ValueError, OverflowError) as error:
            raise _fault(path, line) from error
        put(images, path, "image", key, ModelImage(name, camera, numbers[:4], numbers[4:], table[:, :2], points))
    return images


def read_points(path: Path) -> PointArrays:
    """Read ``points3D.txt``: identifiers, positions, colours and errors; the images hold the observations."""
    rows = []
    for line in filter(_is_record, _lines(path)):
        fields = line.split()
        try:
            if len(fields) < 8 or len(fields) % 2:
                raise ValueError("a record has eight numbers and pairs")
            rows.append((int(fields[0]), *map(float, fields[1:8])))
        except (ValueError, OverflowError) as error:
            raise _fault(path, line) from error
    return point_arrays(path, rows)


def _point(field: str) -> int:
    """Return the identifier of a point, ``NO_POINT`` for one that no 64-bit number can be."""
    identifier = int(field) if field.lstrip("-").isdecimal() else int(float(field))
    return identifier if 0 <= identifier < 1 << 63 else NO_POINT


def _lines(path: Path) -> list[str]:
    """Return the lines of a file in UTF-8, with or without a byte order mark, and with line ends of any system."""
    try:
        return [line.strip() for line in path.read_text(encoding="utf-8-sig").split("\n")]
    except UnicodeDecodeError as error:
        raise UserError(path, "is not text", REMEDY) from error


def _is_record(line: str) -> bool:
    return bool(line) and not line.startswith("#")


def _fault(path: Path, line: str) -> UserError:
    return UserError(path, f"is damaged: cannot read the line '{line[:60]}'", REMEDY)
