"""COLMAP models: a strict reader of the binary and the text form, and a writer of the binary form.

pycolmap 4.2.1 reads a truncated ``cameras.bin`` without a word and leaves wrong numbers in the camera, and does not
return from a truncated ``points3D.bin``; a benchmark needs the file, the fault and the remedy instead. The formats are
described at https://colmap.github.io/format.html. Of a model with rigs only cameras, images and points are read:
``images.bin`` holds each image's own pose there too.
"""

from __future__ import annotations

from pathlib import Path

from avs.scene.colmap import binary, text
from avs.scene.colmap.binary import write_model
from avs.scene.colmap.model import CAMERA_MODELS, NO_POINT, Model, ModelCamera, ModelImage, checked
from avs.system.errors import UserError
from avs.system.regular_files import check_regular

__all__ = [
    "CAMERA_MODELS",
    "NO_POINT",
    "Model",
    "ModelCamera",
    "ModelImage",
    "find_model",
    "has_model",
    "read_model",
    "read_other_form",
    "write_model",
]

_FILES = ("cameras", "images", "points3D")


def has_model(folder: Path) -> bool:
    """Whether ``folder`` holds a file of a model, in any form."""
    return any((folder / f"{name}{suffix}").exists() for name in _FILES for suffix in (".bin", ".txt"))


def find_model(folder: Path) -> tuple[Path, Path, Path]:
    """Return the paths of the cameras, images and points in ``folder``; the binary form is preferred, as COLMAP does.

    Raises:
        UserError: there is no model, or one of its files is missing or no file.
    """
    for suffix in (".bin", ".txt"):
        cameras, images, points = (folder / f"{name}{suffix}" for name in _FILES)
        if not any(path.exists() for path in (cameras, images, points)):
            continue
        for path in (cameras, images, points):
            if not path.exists():
                raise UserError(path, "is missing", "copy the whole folder that COLMAP wrote")
            check_regular(path)
        return cameras, images, points
    fault = "holds no COLMAP model" if folder.is_dir() else "there is no such folder"
    raise UserError(folder, fault, "put cameras, images and points3D there, as .bin or as .txt")


def read_model(folder: Path) -> Model:
    """Read the model in ``folder``, without the observations of points that it lacks; ``Model.dropped`` counts them.

    Raises:
        UserError: there is no model, a file is damaged, or the files contradict one another.
    """
    return _read(folder, *find_model(folder))


def read_other_form(folder: Path) -> Model | None:
    """Return the text form of a model whose binary form is read, or None where there are not both.

    Raises:
        UserError: see ``read_model``.
    """
    cameras, images, points = (folder / f"{name}.txt" for name in _FILES)
    if find_model(folder)[0].suffix == ".txt" or not all(path.is_file() for path in (cameras, images, points)):
        return None
    return _read(folder, cameras, images, points)


def _read(folder: Path, cameras: Path, images: Path, points: Path) -> Model:
    form = binary if cameras.suffix == ".bin" else text
    model = Model(form.read_cameras(cameras), form.read_images(images), *form.read_points(points))
    return checked(folder, cameras.suffix, model)
