"""Captures in LLFF's form (Mildenhall et al., SIGGRAPH 2019): ``poses_bounds.npy`` and the pictures in ``images``.

A row of the file is a 3 x 5 matrix, by rows, and two bounds of depth: the first three columns are the camera's axes in
the world, down, right and backwards, the fourth its centre, the fifth height, width and focal length in pixels. Rows
are in the order of the pictures' names. The bounds are not read; points are triangulated.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from avs.datasets.capture_folders import Layout, is_folder
from avs.datasets.folder_reader import PictureFolderReader
from avs.datasets.found_points import triangulated_points
from avs.datasets.image_names import is_image
from avs.datasets.posed_scene import PosedPictures
from avs.datasets.transforms_file import posed_image
from avs.scene.cameras import FloatArray
from avs.scene.colmap import Model, ModelCamera
from avs.scene.colmap.model import check_camera
from avs.system.errors import UserError
from avs.system.regular_files import check_regular

_FILE = "poses_bounds.npy"
_COPY = "copy the file again"


class Llff(PictureFolderReader):
    """Captures in LLFF's form in a folder of the user's."""

    source: Literal["llff"] = Field(default="llff", description="captures with a poses_bounds.npy")
    folder: str = Field(description="folder of the captures' folders, or that of one capture")

    @classmethod
    def layout(cls) -> Layout:
        """Return how a folder of this form is told from others."""
        return Layout(
            lambda path: is_folder(path) and (path / _FILE).exists(),
            lambda path: [*_pictures(path), path / _FILE],
            _pictures,
            f"{_FILE} and images/",
        )

    def posed(self) -> PosedPictures:
        """Return the pictures with the poses of the file.

        Raises:
            UserError: the file is missing or damaged, or has another number of poses than there are pictures.
        """
        path, root = self.place / _FILE, self.place / "images"
        names = [picture.relative_to(root).as_posix() for picture in _pictures(self.place)]
        rows = _rows(path)
        if len(rows) != len(names):
            fault = f"has {len(rows)} poses, but images/ {len(names)} pictures"
            raise UserError(path, fault, "put those pictures there that the poses are of, and no others")
        cameras: dict[ModelCamera, int] = {}
        images = {}
        for number, (name, row) in enumerate(zip(names, rows, strict=True), 1):
            height, width, focal = map(float, row[:, 4])
            size = round(width), round(height)
            camera = ModelCamera("PINHOLE", *size, (focal, focal, width / 2, height / 2))
            identifier = cameras.setdefault(camera, len(cameras) + 1)
            check_camera(path, identifier, camera)
            images[number] = posed_image(path, name, identifier, _world_to_camera(path, name, row))
        return PosedPictures(
            subject=f"capture {self.place.resolve().name}",
            licence="as the capture's owner says",
            root=root,
            camera_file=path,
            model=Model({identifier: camera for camera, identifier in cameras.items()}, images),
            find_points=triangulated_points,
        )


READER = Llff


def _rows(path: Path) -> FloatArray:
    """Return the matrices of the file, ``[n, 3, 5]``."""
    if not path.exists():
        raise UserError(path, "is missing", "copy the whole capture")
    check_regular(path)
    try:
        table = np.load(path, allow_pickle=False)
    except Exception as error:  # numpy raises many types for a damaged header
        raise UserError(path, "is damaged or cut off, or no table of numbers", _COPY) from error
    if not isinstance(table, np.ndarray):
        raise UserError(path, "is an archive of several tables, not one", _COPY)
    if table.ndim != 2 or table.shape[1] != 17 or not np.issubdtype(table.dtype, np.floating) or not len(table):
        raise UserError(path, f"holds {table.dtype} of shape {table.shape}, not n x 17 numbers", _COPY)
    if not np.isfinite(table).all():
        raise UserError(path, f"the pose {int(np.argwhere(~np.isfinite(table))[0, 0])} is not finite", _COPY)
    rows: FloatArray = table[:, :15].astype(np.float64).reshape(-1, 3, 5)
    return rows


def _world_to_camera(path: Path, name: str, row: FloatArray) -> FloatArray:
    """Return the inverse of a pose, ``[4, 4]``, in OpenCV axes: right, down, forwards."""
    if not row[:, :3].any():
        raise UserError(path, f"the pose of {name} is all zero", "take the picture and its pose out")
    axes = np.stack([row[:, 1], row[:, 0], -row[:, 2]])
    transform = np.eye(4)
    transform[:3, :3], transform[:3, 3] = axes, -axes @ row[:, 3]
    return transform


def _pictures(folder: Path) -> list[Path]:
    return sorted(path for path in (folder / "images").glob("*") if is_image(path) and path.is_file())
