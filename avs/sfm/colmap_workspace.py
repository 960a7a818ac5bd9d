"""Views in a folder as COLMAP reads them, and what comes back of it. Images are named by their row, whatever theirs."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from avs.scene.cameras import Cameras
from avs.scene.colmap import write_model
from avs.scene.colmap.conversion import as_model
from avs.scene.points import Points
from avs.scene.views import Views
from avs.sfm.cloud import Cloud, empty_cloud
from avs.system.files import temporary_folder

NO_POINTS = Points(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.uint8), np.zeros((0, 2), dtype=np.int64))


def library() -> Any:  # noqa: ANN401 - pycolmap has no types
    """Return pycolmap, which from now on tells of errors alone."""
    import pycolmap

    pycolmap.logging.minloglevel = pycolmap.logging.ERROR.value
    return pycolmap


@contextlib.contextmanager
def workspace(views: Views) -> Iterator[Path]:
    """Yield a temporary folder with ``images/`` and the model ``sparse/`` of the cameras; it is removed at the end.

    Args:
        views: n views. Image r is called ``row_name(r)`` and has the identifier r + 1.
    """
    with temporary_folder("avs-sfm-") as folder:
        (folder / "images").mkdir()
        for row, pixels in enumerate(views.images):
            Image.fromarray(pixels).save(folder / "images" / row_name(row))
        names = [row_name(row) for row in range(len(views))]
        write_model(folder / "sparse", as_model(names, views.cameras, NO_POINTS))
        yield folder


def row_name(row: int) -> str:
    """Return the file name of image ``row``; a form without compression, as the files live for seconds."""
    return f"{row:05d}.bmp"


def row_of(name: str) -> int:
    """Return the row of an image by its file name."""
    return int(Path(name).stem)


def cloud_of(model: Any) -> Cloud:  # noqa: ANN401
    """Return the points of a ``pycolmap.Reconstruction``, in the order of their identifiers.

    The confidence of a point is the number of views that see it.
    """
    points = [model.points3D[identifier] for identifier in sorted(model.points3D)]
    if not points:
        return empty_cloud()
    return Cloud(
        np.array([point.xyz for point in points], dtype=np.float64),
        np.array([point.color for point in points], dtype=np.uint8),
        np.array([len({element.image_id for element in point.track.elements}) for point in points], dtype=np.float32),
    )


def cameras_of_model(model: Any, rows: list[int], views: Views) -> Cameras:  # noqa: ANN401
    """Return the cameras of a ``pycolmap.Reconstruction`` for the views at ``rows``, with the intrinsics given."""
    by_row = {row_of(image.name): image.cam_from_world() for image in model.images.values() if image.has_pose}
    transforms = np.tile(np.eye(4), (len(rows), 1, 1))
    transforms[:, :3] = np.array([by_row[row].matrix() for row in rows]).reshape(-1, 3, 4)
    return Cameras(transforms, views.cameras.intrinsics[rows], views.cameras.sizes[rows])
