"""Captures: any folder in COLMAP layout, ``images/`` and ``sparse/0``, becomes a scene.

A scene has PINHOLE cameras. Cameras of other models are undistorted as COLMAP's ``image_undistorter`` does it, without
blank pixels; those whose distortion is zero keep their pixels. Every image may have its own intrinsics and size.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Literal, Self

import numpy as np
from PIL import Image
from pydantic import Field

from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.reader import Reader
from avs.datasets.undistortion import pinhole, rescaled, undistorted_camera, undistorted_image
from avs.scene.cameras import Cameras, IndexArray
from avs.scene.colmap import Model, ModelCamera, ModelImage, find_model, read_model
from avs.scene.colmap.conversion import cameras_of, points_of, sorted_images
from avs.scene.images import Pixels, open_image, read_image
from avs.scene.points import Points
from avs.scene.scene import write_scene
from avs.system.errors import UserError
from avs.system.files import explained

_IMAGE_SUFFIXES = {".bmp", ".jpeg", ".jpg", ".png", ".tif", ".tiff", ".webp"}
_KEPT_SUFFIXES = {"JPEG": {".jpg", ".jpeg"}, "PNG": {".png"}}
_ORIENTATION = 0x0112  # EXIF tag; 1 is upright, 5 to 8 exchange width and height
_FILTERS = {"pil": Image.Resampling.BICUBIC, "area": Image.Resampling.BOX}


class Captures(Reader, CaptureSettings):
    """Captures in a folder of the user's."""

    source: Literal["captures"] = Field(default="captures", description="captures in COLMAP layout")
    folder: str | None = Field(
        default=None, description="folder of captures, or one capture; null where the option scenes_dir gives it"
    )

    def scenes(self) -> dict[str, Self]:
        """Return the settings of each capture, by its name in lower case, in order; see ``list_captures``."""
        if self.folder is None:
            raise UserError("captures", "no folder is given", "add --config scenes_dir=DIR, or name a folder")
        found = sorted(list_captures(Path(self.folder)).items())
        return {name: self.model_copy(update={"folder": str(path)}) for name, path in found}

    def files(self) -> list[Path]:
        """Return every file of the capture."""
        return sorted(path for path in self._folder.rglob("*") if path.is_file())

    def identity(self) -> tuple[object, ...]:
        """Return the capture's folder."""
        return (self.source, str(self._folder.resolve()))

    def prepare(self, dataset: str, folder: Path) -> None:
        """Turn the capture into a scene; see ``prepare`` of this module."""
        prepare(self._folder, folder, self, dataset)

    @property
    def _folder(self) -> Path:
        return Path(self.folder or ".")


READER = Captures


@dataclass(frozen=True)
class _Picture:
    """One registered image and what becomes of it.

    Attributes:
        name: its name in the model.
        path: its file.
        turned: whether its EXIF orientation has to be applied to agree with its camera.
        camera: its camera, of the file's pixels (turned).
        straight: the PINHOLE camera without distortion, before the image is resized.
        size: width and height in the scene.
        kept: whether the file goes into the scene as it is.
    """

    name: str
    path: Path
    turned: bool
    camera: ModelCamera
    straight: ModelCamera
    size: tuple[int, int]
    kept: bool

    def read(self, settings: CaptureSettings) -> Pixels | Path:
        """Return the pixels for the scene, or the file where it is kept."""
        if self.kept:
            return self.path
        pixels = read_image(self.path, self.turned)
        if pinhole(self.camera) is None:
            pixels = undistorted_image(pixels, self.camera)
        if self.size == (self.straight.width, self.straight.height):
            return pixels
        return np.asarray(Image.fromarray(pixels).resize(self.size, _FILTERS[settings.resample]))

    def stored_name(self) -> str:
        """Return the name in the scene: images that change are stored as PNG."""
        return self.name if self.kept else str(PurePosixPath(self.name).with_suffix(".png"))


def list_captures(folder: Path) -> dict[str, Path]:
    """Find the captures in ``folder``: its subfolders with ``images`` or ``sparse`` in them, or the folder itself.

    Returns:
        Their folders by scene name: lower case, with ``_`` for every character other than a letter, a digit or ``_``.

    Raises:
        UserError: there is none, two get the same name, or the folder cannot be read.
    """
    folder = Path(folder)
    with explained():
        if not folder.is_dir():
            raise UserError(folder, "there is no such folder", "give the folder that holds your captures")
        candidates = [folder] if _is_capture(folder) else sorted(filter(_is_capture, folder.iterdir()))
    captures: dict[str, Path] = {}
    for path in candidates:
        name = re.sub("[^a-z0-9_]", "_", path.resolve().name.lower())
        if name in captures:
            raise UserError(path, f"has the same scene name, {name}, as {captures[name]}", "rename one of them")
        captures[name] = path
    if not captures:
        raise UserError(folder, "holds no capture", "give a folder of folders that have images/ and sparse/0/ in them")
    return captures


def prepare(source: Path, folder: Path, settings: CaptureSettings, dataset: str = "captures") -> None:
    """Turn the capture in ``source`` into a scene of ``dataset`` in ``folder``, named after ``folder``.

    Only registered images are used. Every ``settings.test_every``-th of them by name, from the first on, is a test
    image.

    Raises:
        UserError: the model or an image is missing or damaged, or they contradict one another.
    """
    source, folder = Path(source), Path(folder)
    sparse, notes = _find_sparse(source)
    model = read_model(sparse)
    if not model.images:
        raise UserError(find_model(sparse)[1], "registers no image", "run the structure from motion again")
    images = sorted_images(model)
    camera_file = find_model(sparse)[0]
    pictures = [_plan(source, camera_file, model.cameras[image.camera_id], image, settings) for image in images]
    cameras = _cameras(model, pictures)
    points = _visible(points_of(model), cameras)
    names = _unique_names(pictures)
    order = sorted(range(len(names)), key=names.__getitem__)
    places = np.argsort(order)
    write_scene(
        folder,
        name=folder.name,
        dataset=dataset,
        names=[names[index] for index in order],
        images=(pictures[index].read(settings) for index in order),
        cameras=cameras[order],
        test=np.sort(places[:: settings.test_every]),
        points=_reordered(points, places),
        source=f"capture {source.resolve().name}",
        licence="as the capture's owner says",
        notes=notes + _notes(source, pictures, points),
    )


def _is_capture(path: Path) -> bool:
    return not path.name.startswith(".") and ((path / "images").is_dir() or (path / "sparse").is_dir())


def _find_sparse(source: Path) -> tuple[Path, list[str]]:
    """Return the folder of the model, ``sparse/0`` or else ``sparse``, and notes on models that are not used."""
    sparse = source / "sparse"
    others = [path.name for path in sorted(sparse.glob("[1-9]*")) if path.is_dir()]
    notes = [f"sparse/{name} is not used, only sparse/0" for name in others]
    if not (sparse / "0").is_dir() and any(sparse.glob("cameras.*")):
        return sparse, notes
    return sparse / "0", notes


def _plan(source: Path, cameras: Path, camera: ModelCamera, image: ModelImage, settings: CaptureSettings) -> _Picture:
    """Look at an image's header and its camera and decide what becomes of it."""
    relative = PurePosixPath(image.name)
    if relative.is_absolute() or ".." in relative.parts:
        raise UserError(cameras.parent, f"image name {image.name} points outside the folder images", "rename the image")
    path = source / "images" / relative
    with open_image(path) as header:
        stored, kind, orientation = header.size, header.format, header.getexif().get(_ORIENTATION, 1)
    turned = orientation >= 5 and _fits(stored[::-1], camera) and not _fits(stored, camera)
    width, height = stored[::-1] if turned else stored
    if not _fits((width, height), camera):
        fault = f"the image is {width} x {height} pixels, its camera {camera.width} x {camera.height}"
        raise UserError(path, fault, "use the images that the model was made from")
    if (width, height) != (camera.width, camera.height):
        camera = rescaled(camera, width, height)
    straight = pinhole(camera) or undistorted_camera(camera)
    if straight is None:
        fault = f"camera {image.camera_id} ({camera.model}) cannot be undistorted"
        raise UserError(cameras, fault, "use images of a perspective or fisheye camera")
    size = settings.image_size(straight.width, straight.height)
    same = straight == pinhole(camera) and size == (width, height) and orientation == 1
    kept = same and path.suffix.lower() in _KEPT_SUFFIXES.get(kind or "", ())
    return _Picture(image.name, path, turned, camera, straight, size, kept)


def _fits(size: tuple[int, int], camera: ModelCamera) -> bool:
    """Whether an image of ``size`` shows what ``camera`` does: same shape, up to the rounding of a resized side."""
    width, height = size
    return abs(width * camera.height - height * camera.width) <= max(camera.width, camera.height)


def _unique_names(pictures: list[_Picture]) -> list[str]:
    """Return the names in the scene; where two would be equal (a.jpg and a.bmp), they keep their old suffix too."""
    names = [picture.stored_name() for picture in pictures]
    return [
        name if names.count(name) == 1 or picture.kept else f"{picture.name}.png"
        for name, picture in zip(names, pictures, strict=True)
    ]


def _cameras(model: Model, pictures: list[_Picture]) -> Cameras:
    """Return the cameras of the scene's images, in the order of the pictures."""
    images = {row: replace(image, camera_id=row) for row, image in enumerate(sorted_images(model))}
    straight = {row: picture.straight for row, picture in enumerate(pictures)}
    sizes = np.array([picture.size for picture in pictures], dtype=np.int64)
    return cameras_of(replace(model, cameras=straight, images=images)).resized(sizes)


def _visible(points: Points, cameras: Cameras) -> Points:
    """Leave out observations behind the camera or outside the image, which undistortion may have cut."""
    rows, images = points.observations.T
    local = np.einsum("oij,oj->oi", cameras.world_to_camera[images, :3, :3], points.positions[rows])
    local += cameras.world_to_camera[images, :3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = np.einsum("oij,oj->oi", cameras.intrinsics[images], local / local[:, 2:])[:, :2]
    seen = (local[:, 2] > 0) & (pixels >= 0).all(axis=1) & (pixels < cameras.sizes[images]).all(axis=1)
    return replace(points, observations=points.observations[seen])


def _reordered(points: Points, places: IndexArray) -> Points:
    """Return ``points`` after image i has become image ``places[i]``."""
    rows, images = points.observations.T
    observations = np.stack([rows, places[images]], axis=1)
    return replace(points, observations=np.unique(observations, axis=0))


def _notes(source: Path, pictures: list[_Picture], points: Points) -> list[str]:
    """Return what a reader of the scene should know."""
    notes = []
    used = {picture.path for picture in pictures}
    present = {path for path in (source / "images").rglob("*") if path.suffix.lower() in _IMAGE_SUFFIXES}
    if present - used:
        notes.append(f"{len(present - used)} of {len(present)} images are left out: the model does not register them")
    bent = sum(pinhole(picture.camera) is None for picture in pictures)
    if bent:
        notes.append(f"{bent} images are undistorted")
    if not len(points):
        notes.append("the model has no points")
    return notes
