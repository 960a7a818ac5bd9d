"""The binary form of COLMAP models, ``.bin``."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from avs.scene.colmap.model import (
    CAMERA_MODELS,
    NO_POINT,
    NUMBERS,
    REMEDY,
    Model,
    ModelCamera,
    ModelImage,
    PointArrays,
    point_arrays,
    put,
)
from avs.system.errors import UserError

# One row of an image's list of keypoints, as the binary form packs it.
_KEYPOINT = np.dtype([("xy", "<f8", 2), ("point", "<i8")])


def write_model(folder: Path, model: Model) -> None:
    """Write the three binary files into ``folder``, ascending by identifier; equal models give equal bytes."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "cameras.bin").write_bytes(b"".join(_camera_records(model)))
    (folder / "images.bin").write_bytes(b"".join(_image_records(model)))
    (folder / "points3D.bin").write_bytes(b"".join(_point_records(model)))


def _camera_records(model: Model) -> Iterator[bytes]:
    yield struct.pack("<Q", len(model.cameras))
    for identifier, camera in sorted(model.cameras.items()):
        yield struct.pack("<IiQQ", identifier, NUMBERS[camera.model], camera.width, camera.height)
        yield struct.pack(f"<{len(camera.params)}d", *camera.params)


def _image_records(model: Model) -> Iterator[bytes]:
    yield struct.pack("<Q", len(model.images))
    for identifier, image in sorted(model.images.items()):
        yield struct.pack("<I7dI", identifier, *image.quaternion, *image.translation, image.camera_id)
        yield image.name.encode() + b"\0" + struct.pack("<Q", len(image.points))
        rows = np.empty(len(image.points), _KEYPOINT)
        rows["xy"], rows["point"] = image.keypoints, image.points
        yield rows.tobytes()


def _point_records(model: Model) -> Iterator[bytes]:
    yield struct.pack("<Q", len(model.point_ids))
    for row, track in enumerate(_tracks(model)):
        numbers = (*model.positions[row], *model.colors[row], model.errors[row])
        yield struct.pack("<Q3d3Bd", model.point_ids[row], *numbers)
        yield struct.pack("<Q", len(track)) + track.tobytes()


def _tracks(model: Model) -> list[npt.NDArray[np.uint32]]:
    """For every point the ``[t, 2]`` pairs of image identifier and keypoint row that observe it."""
    parts = [np.zeros((0, 3), np.int64)]
    for identifier, image in sorted(model.images.items()):
        rows = np.flatnonzero(image.points != NO_POINT)
        parts.append(np.stack([image.points[rows], np.full(len(rows), identifier), rows], axis=1))
    table = np.concatenate(parts)
    table = table[np.argsort(table[:, 0], kind="stable")]
    bounds = np.searchsorted(table[:, 0], model.point_ids)
    return np.split(table[:, 1:].astype("<u4"), bounds[1:]) if len(model.point_ids) else []


class _Bytes:
    """A binary file read front to back; reading past its end is an error that names the file."""

    def __init__(self, path: Path) -> None:
        self.path, self.data, self.position = path, path.read_bytes(), 0

    def raw(self, length: int) -> bytes:
        start, self.position = self.position, self.position + length
        if self.position > len(self.data):
            raise UserError(self.path, f"is damaged or cut off: it ends at byte {len(self.data)}", REMEDY)
        return self.data[start : self.position]

    def unpack(self, layout: str) -> tuple[float, ...]:
        return struct.unpack("<" + layout, self.raw(struct.calcsize("<" + layout)))

    def integer(self, layout: str = "Q") -> int:
        return int(self.unpack(layout)[0])

    def string(self) -> str:
        end = self.data.find(b"\0", self.position)
        text = self.raw((end if end >= 0 else len(self.data)) - self.position + 1)[:-1]
        try:
            return text.decode()
        except UnicodeDecodeError as error:
            raise UserError(self.path, f"is damaged before byte {self.position}: no text", REMEDY) from error

    def finish(self) -> None:
        if self.position != len(self.data):
            fault = f"is damaged: {len(self.data) - self.position} bytes follow the last record"
            raise UserError(self.path, fault, REMEDY)


def read_cameras(path: Path) -> dict[int, ModelCamera]:
    """Read ``cameras.bin``: cameras by identifier."""
    source = _Bytes(path)
    cameras: dict[int, ModelCamera] = {}
    for _ in range(source.integer()):
        identifier, number = source.integer("I"), source.integer("i")
        if number not in CAMERA_MODELS:
            fault = f"camera {identifier} has the unknown camera model {number}"
            raise UserError(path, fault, "write the model with a known one, such as OPENCV")
        model, count = CAMERA_MODELS[number]
        width, height = source.integer(), source.integer()
        put(cameras, path, "camera", identifier, ModelCamera(model, width, height, source.unpack(f"{count}d")))
    source.finish()
    return cameras


def read_images(path: Path) -> dict[int, ModelImage]:
    """Read ``images.bin``: images by identifier."""
    source = _Bytes(path)
    images: dict[int, ModelImage] = {}
    for _ in range(source.integer()):
        identifier = source.integer("I")
        pose = np.array(source.unpack("7d"))
        camera_id, name = source.integer("I"), source.string()
        rows = np.frombuffer(source.raw(source.integer() * _KEYPOINT.itemsize), _KEYPOINT)
        points = rows["point"].astype(np.int64)
        image = ModelImage(name, camera_id, pose[:4], pose[4:], rows["xy"].astype(np.float64), points)
        put(images, path, "image", identifier, image)
    source.finish()
    return images


def read_points(path: Path) -> PointArrays:
    """Read ``points3D.bin``: identifiers, positions, colours and errors; the images hold the observations."""
    source = _Bytes(path)
    rows = []
    for _ in range(source.integer()):
        rows.append(source.unpack("Q3d3Bd"))
        source.raw(8 * source.integer())
    source.finish()
    return point_arrays(path, rows)
