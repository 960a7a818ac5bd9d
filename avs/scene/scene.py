"""Scene: cameras, images, split and points, in the COLMAP layout on disk.

A scene folder holds ``images/``, ``sparse/0/*.bin`` (PINHOLE cameras) and ``scene.json``; any COLMAP viewer opens it.
Scenes with known geometry add ``depth/<image stem>.npy`` (float32 ``[height, width]``, scene units along the optical
axis) and ``mesh.ply``.
"""

from __future__ import annotations

import hashlib
import re
import shutil
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from avs.scene.cameras import Cameras, IndexArray
from avs.scene.colmap import read_model, write_model
from avs.scene.colmap.conversion import as_model, cameras_of, points_of, sorted_images
from avs.scene.images import Pixels, pixel_hash, read_image, store_image
from avs.scene.points import Points
from avs.scene.views import Views
from avs.system.errors import UserError
from avs.system.files import atomic_folder, canonical_json, file_hash, write_json
from avs.system.models import StrictModel
from avs.system.records import read_record

__all__ = ["Points", "Scene", "SceneFile", "read_scene", "scene_extent", "write_scene"]

_REMEDY = "prepare the scene again"
_SCENE_NAME = re.compile(r"[a-z0-9_]+")
_SUFFIXES = {".png", ".jpg", ".jpeg"}
_MODEL_FILES = ("sparse/0/cameras.bin", "sparse/0/images.bin", "sparse/0/points3D.bin")


class SceneFile(StrictModel):
    """``scene.json``: what the COLMAP files do not say, and the hashes of all that they do."""

    schema_version: Literal[1] = 1
    name: str = Field(description="identifier, [a-z0-9_]+", pattern=r"^[a-z0-9_]+$")
    dataset: str = Field(description="name of the data set it belongs to, such as orbit or captures")
    test: list[str] = Field(description="names of the test images, ascending; all others are the pool")
    extent: float = Field(description="1.1 times the greatest distance of a camera centre from their mean (3DGS)")
    source: str = Field(description="where the pictures come from, one line")
    licence: str = Field(description="licence of the pictures, one line")
    notes: list[str] = Field(description="what a reader should know about the scene, such as images that were left out")
    images: dict[str, str] = Field(description="image name to the SHA-256 of its size and pixels")
    files: dict[str, str] = Field(description="path of every other file of the scene to the SHA-256 of its bytes")
    content_hash: str = Field(description="SHA-256 over images, files and test in canonical JSON")


@dataclass(frozen=True)
class Scene:
    """One capture. Images are in ascending order of name; ``cameras`` and ``names`` share that order.

    Attributes:
        name: identifier, ``[a-z0-9_]+``.
        dataset: name of the data set it belongs to, such as ``orbit`` or ``captures``.
        folder: where it lies on disk; images are read from ``folder / "images"`` on demand.
        names: image file names, ascending.
        cameras: one per image, of the images' pixel sizes.
        test: indices of the test images, ascending. All others are the pool of candidates.
        points: sparse points; may be empty.
        extent: 1.1 times the greatest distance of a camera centre from the mean of all centres (3DGS,
            ``getNerfppNorm``).
        source: where the pictures come from, one line.
        licence: their terms, one line.
        content_hash: SHA-256 over the images, the cameras, the split, the points, and depth and mesh where there are
            any.
        hashes: SHA-256 of every image's pixels, in the order of ``names``.
        notes: what a reader should know about the scene, such as images that were left out.
    """

    name: str
    dataset: str
    folder: Path
    names: tuple[str, ...]
    cameras: Cameras
    test: IndexArray
    points: Points
    extent: float
    source: str
    licence: str
    content_hash: str
    hashes: tuple[str, ...]
    notes: tuple[str, ...] = ()

    @property
    def pool(self) -> IndexArray:
        """Indices of the candidate images, ascending: every image that is not a test image."""
        return np.setdiff1d(np.arange(len(self.names)), self.test)

    def views(self, indices: Sequence[int] | IndexArray) -> Views:
        """Read the images at ``indices`` and return them with their cameras, in the order given.

        Raises:
            UserError: an image is missing, truncated, or not the one that ``scene.json`` lists.
        """
        rows = np.asarray(indices, dtype=np.int64)
        images = []
        for index in rows:
            path = self.folder / "images" / self.names[index]
            pixels = read_image(path)
            if pixel_hash(pixels) != self.hashes[index]:
                raise UserError(path, "is not the image that scene.json lists", _REMEDY)
            images.append(pixels)
        return Views(self.cameras[rows], tuple(images), tuple(self.names[row] for row in rows))


def scene_extent(cameras: Cameras) -> float:
    """Return 1.1 times the greatest distance of a camera centre from the mean of all centres."""
    centers = cameras.centers
    return float(1.1 * np.linalg.norm(centers - centers.mean(axis=0), axis=1).max())


def write_scene(
    folder: Path,
    *,
    name: str,
    dataset: str,
    names: Sequence[str],
    images: Iterable[Pixels | Path],
    cameras: Cameras,
    test: IndexArray,
    points: Points,
    source: str,
    licence: str,
    depth: Iterable[npt.NDArray[np.float32]] | None = None,
    mesh: Path | None = None,
    notes: Sequence[str] = (),
) -> None:
    """Write a scene, whole or not at all; equal content gives equal bytes.

    Args:
        folder: the scene's folder; what was there is replaced.
        name: identifier, ``[a-z0-9_]+``.
        dataset: name of the data set.
        names: n file names below ``images/``, ascending; ``.png`` for arrays, ``.png`` or ``.jpg`` for files.
        images: n images, each ``[height, width, 3]`` uint8 sRGB, or a file whose bytes are copied. They are consumed
            one by one, so that a generator keeps one in memory.
        cameras: n cameras of the images' sizes.
        test: indices of the test images.
        points: sparse points; every observation must lie in front of its camera.
        source: where the pictures come from, one line.
        licence: their terms, one line.
        depth: n arrays ``[height, width]`` float32, scene units along the optical axis, 0 where nothing is; or None.
        mesh: a PLY file to copy; or None.
        notes: lines for ``scene.json``.

    Raises:
        ValueError: the parts contradict one another.
        UserError: an image file is missing or damaged.
    """
    _check_parts(name, names, cameras, test, points)
    with atomic_folder(folder) as temporary:
        hashes = _write_images(temporary / "images", names, images, cameras)
        write_model(temporary / "sparse" / "0", as_model(names, cameras, points))
        if depth is not None:
            _write_depth(temporary / "depth", names, depth)
        if mesh is not None:
            shutil.copyfile(mesh, temporary / "mesh.ply")
        paths = {path.relative_to(temporary).as_posix(): path for path in temporary.rglob("*") if path.is_file()}
        files = {name: file_hash(path) for name, path in paths.items() if not name.startswith("images/")}
        test_names = [names[index] for index in sorted(test)]
        scene = SceneFile(
            name=name,
            dataset=dataset,
            test=test_names,
            extent=scene_extent(cameras),
            source=source,
            licence=licence,
            notes=list(notes),
            images=hashes,
            files=files,
            content_hash=_content_hash(hashes, files, test_names),
        )
        write_json(temporary / "scene.json", scene.model_dump(mode="json"))


def read_scene(folder: Path) -> Scene:
    """Read the scene in ``folder``; its images are read when ``Scene.views`` asks for them.

    Raises:
        UserError: a file is missing, damaged or contradicts another.
    """
    folder = Path(folder)
    listed = _read_scene_file(folder)
    model = read_model(folder / "sparse" / "0")
    if any(camera.model != "PINHOLE" for camera in model.cameras.values()):
        raise UserError(folder / "sparse/0/cameras.bin", "holds a camera that is not PINHOLE", _REMEDY)
    names = tuple(image.name for image in sorted_images(model))
    if list(names) != sorted(listed.images) or not set(listed.test) <= set(names):
        raise UserError(folder / "scene.json", "its images are not those of the model", _REMEDY)
    return Scene(
        name=listed.name,
        dataset=listed.dataset,
        folder=folder,
        names=names,
        cameras=cameras_of(model),
        test=np.array(sorted(names.index(name) for name in listed.test), dtype=np.int64),
        points=points_of(model),
        extent=listed.extent,
        source=listed.source,
        licence=listed.licence,
        content_hash=listed.content_hash,
        hashes=tuple(listed.images[name] for name in names),
        notes=tuple(listed.notes),
    )


def _read_scene_file(folder: Path) -> SceneFile:
    """Read ``scene.json`` and check that the model's files are the ones that it lists."""
    path = folder / "scene.json"
    if not path.is_file():
        raise UserError(path, "is missing", _REMEDY)
    listed = read_record(path, SceneFile, _REMEDY)
    if listed.content_hash != _content_hash(listed.images, listed.files, listed.test):
        raise UserError(path, "its content hash does not fit its lists", _REMEDY)
    for name in _MODEL_FILES:
        if name not in listed.files or not (folder / name).is_file():
            raise UserError(folder / name, "is missing", _REMEDY)
        if file_hash(folder / name) != listed.files[name]:
            raise UserError(folder / name, "is not the file that scene.json lists", _REMEDY)
    return listed


def _write_images(
    folder: Path, names: Sequence[str], images: Iterable[Pixels | Path], cameras: Cameras
) -> dict[str, str]:
    """Write the images and return the hashes of their pixels by name."""
    hashes = {}
    for name, image, (width, height) in zip(names, images, cameras.sizes, strict=True):
        pixels = store_image(folder / name, image)
        if pixels.shape != (height, width, 3):
            raise ValueError(f"image {name} has shape {pixels.shape}, its camera {width} x {height} pixels")
        hashes[name] = pixel_hash(pixels)
    return hashes


def _write_depth(folder: Path, names: Sequence[str], depth: Iterable[npt.NDArray[np.float32]]) -> None:
    for name, distances in zip(names, depth, strict=True):
        path = folder / PurePosixPath(name).with_suffix(".npy")
        path.parent.mkdir(parents=True, exist_ok=True)
        np.save(path, np.asarray(distances, dtype=np.float32), allow_pickle=False)


def _content_hash(images: dict[str, str], files: dict[str, str], test: list[str]) -> str:
    content = canonical_json({"images": images, "files": files, "test": test})
    return hashlib.sha256(content.encode()).hexdigest()


def _check_parts(name: str, names: Sequence[str], cameras: Cameras, test: IndexArray, points: Points) -> None:
    if not _SCENE_NAME.fullmatch(name):
        raise ValueError(f"scene name {name!r} is not [a-z0-9_]+")
    if len(names) == 0 or len(names) != len(cameras) or list(names) != sorted(set(names)):
        raise ValueError(f"{len(names)} image names for {len(cameras)} cameras: not ascending, repeated, or too few")
    for image in map(PurePosixPath, names):
        if image.is_absolute() or ".." in image.parts or image.suffix.lower() not in _SUFFIXES:
            raise ValueError(f"image name {image} is not a path below images/ that ends in {sorted(_SUFFIXES)}")
    if len(np.unique(test)) != len(test) or (len(test) and not 0 <= np.min(test) <= np.max(test) < len(names)):
        raise ValueError("test holds an index twice, or one that is not an image's")
    shape = (len(points), 3)
    if points.positions.shape != shape or points.colors.shape != shape or points.colors.dtype != np.uint8:
        raise ValueError(
            f"points have shapes {points.positions.shape} and {points.colors.shape}, {points.colors.dtype}"
        )
    limits = np.array([len(points), len(names)])
    if len(points.observations) and not ((points.observations >= 0) & (points.observations < limits)).all():
        raise ValueError("an observation names a point or an image that does not exist")
