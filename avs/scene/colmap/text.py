"""The text form of COLMAP models, ``.txt``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avs.scene.colmap.model import PARAMETERS, REMEDY, ModelCamera, ModelImage, PointArrays, point_arrays
from avs.system.errors import UserError


def read_cameras(path: Path) -> dict[int, ModelCamera]:
    """Read ``cameras.txt``: cameras by identifier."""
    cameras = {}
    for line in filter(_is_record, _lines(path)):
        try:
            identifier, model, width, height, *params = line.split()
            camera = ModelCamera(model, int(width), int(height), tuple(map(float, params)))
            cameras[int(identifier)] = camera
        except ValueError as error:
            raise _fault(path, line) from error
        if camera.model not in PARAMETERS:
            fault = f"camera {identifier} has the unknown camera model {model}"
            raise UserError(path, fault, "write the model with a known one, such as OPENCV")
        if len(params) != PARAMETERS[model]:
            raise _fault(path, line)
    return cameras


def read_images(path: Path) -> dict[int, ModelImage]:
    """Read ``images.txt``: images by identifier."""
    images = {}
    lines = iter(_lines(path))
    for line in lines:
        if not _is_record(line):
            continue
        keypoints = next(lines, "")
        try:
            identifier, *pose, camera_id, name = line.split(maxsplit=9)
            numbers = np.array(pose, dtype=np.float64)
            table = np.array(keypoints.split(), dtype=np.float64).reshape(-1, 3)
            key, camera = int(identifier), int(camera_id)
        except ValueError as error:
            raise _fault(path, line) from error
        points = table[:, 2].astype(np.int64)
        images[key] = ModelImage(name, camera, numbers[:4], numbers[4:], table[:, :2], points)
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
        except ValueError as error:
            raise _fault(path, line) from error
    return point_arrays(rows)


def _lines(path: Path) -> list[str]:
    try:
        return [line.strip() for line in path.read_text(encoding="utf-8").splitlines()]
    except UnicodeDecodeError as error:
        raise UserError(path, "is not text", REMEDY) from error


def _is_record(line: str) -> bool:
    return bool(line) and not line.startswith("#")


def _fault(path: Path, line: str) -> UserError:
    return UserError(path, f"is damaged: cannot read the line '{line[:60]}'", REMEDY)
