"""Scene: cameras, images, split and points, in the COLMAP layout on disk.

A scene folder holds ``images/``, ``sparse/0/*.bin`` (PINHOLE cameras) and ``scene.json``; any COLMAP viewer opens it.
Scenes with known geometry add ``depth/<image stem>.npy`` (float32 ``[height, width]``, scene units along the optical
axis) and ``mesh.ply``. Everything in it has the scene's own unit and origin (``avs.scene.normalisation``).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, IndexArray
from avs.scene.colmap import read_model, write_model
from avs.scene.colmap.conversion import as_model, cameras_of, points_of, sorted_images
from avs.scene.images import Pixels, pixel_hash, read_image, store_image
from avs.scene.mesh import write_moved_mesh
from avs.scene.normalisation import EXTENT, normalisation, stray_note
from avs.scene.photograph_agreement import disagreement_notes
from avs.scene.point_colors import colored
from avs.scene.points import Points
from avs.scene.scene_file import REMEDY, SceneFile, read_scene_file
from avs.scene.similarity import Similarity
from avs.scene.views import Views
from avs.system.errors import UserError
from avs.system.files import atomic_folder, file_hash
from avs.system.records import write_record

__all__ = ["Points", "Scene", "SceneFile", "read_scene", "write_scene"]

_SCENE_NAME = re.compile(r"[a-z0-9_]+")
_SUFFIXES = {".png", ".jpg", ".jpeg"}


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
        extent: 1.1 times the greatest distance of a camera centre of the pool from their mean, which is the origin
            (3DGS, ``getNerfppNorm``), stray cameras left out; the same in all scenes: see ``avs.scene.normalisation``.
        to_capture: from scene coordinates to those of the capture.
        source: where the pictures come from, one line.
        licence: their terms, one line.
        content_hash: SHA-256 over everything that is written of the scene.
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
    to_capture: Similarity
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
                raise UserError(path, "is not the image that scene.json lists", REMEDY)
            images.append(pixels)
        return Views(self.cameras[rows], tuple(images), tuple(self.names[row] for row in rows))


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
    cut_out: Collection[str] = (),
) -> dict[str, str]:
    """Write a scene, whole or not at all; equal content gives equal bytes.

    Cameras, points, depth and mesh are given in the capture's own unit and origin and written in the scene's. Points
    without colours get those of the photographs. Notes tell of that, and of stray cameras.

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
        depth: n arrays ``[height, width]`` float32 along the optical axis, 0 where nothing is; or None.
        mesh: a PLY file; or None.
        notes: lines for ``scene.json``.
        cut_out: names of the images that are known to be masked, since their files have transparency.

    Returns:
        The SHA-256 of each image's size and pixels, by name.

    Raises:
        ValueError: the parts contradict one another.
        UserError: an image file is missing or damaged; the cameras stand in one place; or something lies farther out
            than numbers reach.
    """
    _check_parts(name, names, cameras, test, points)
    pool = np.setdiff1d(np.arange(len(names)), test)
    to_capture, stray = normalisation(cameras, points.positions, pool, source)
    cameras = to_capture.cameras_back(cameras)
    points = replace(points, positions=to_capture.points_back(points.positions))
    told = [*notes, stray_note([names[index] for index in stray])] if len(stray) else list(notes)
    with atomic_folder(folder) as temporary:
        hashes = _write_images(temporary / "images", names, images, cameras)

        def read(index: int) -> Pixels:
            return read_image(temporary / "images" / names[index])

        found = disagreement_notes(names, points, cameras, read, cut_out)
        points, note = colored(points, cameras, pool, read)
        told += [*found, *filter(None, [note])]
        _write_geometry(temporary, names, cameras, points, depth, mesh, to_capture)
        listed = SceneFile(
            name=name,
            dataset=dataset,
            test=[names[index] for index in sorted(test)],
            extent=EXTENT,
            to_capture=to_capture,
            source=source,
            licence=licence,
            notes=told,
            images=hashes,
            files=_hashes_beside_images(temporary),
        )
        write_record(temporary / "scene.json", listed.hashed())
    return hashes


def read_scene(folder: Path) -> Scene:
    """Read the scene in ``folder``; its images are read when ``Scene.views`` asks for them.

    Raises:
        UserError: a file is missing, damaged or contradicts another.
    """
    folder = Path(folder)
    listed = read_scene_file(folder)
    model = read_model(folder / "sparse" / "0")
    if any(camera.model != "PINHOLE" for camera in model.cameras.values()):
        raise UserError(folder / "sparse/0/cameras.bin", "holds a camera that is not PINHOLE", REMEDY)
    names = tuple(image.name for image in sorted_images(model))
    if list(names) != sorted(listed.images) or not set(listed.test) <= set(names):
        raise UserError(folder / "scene.json", "its images are not those of the model", REMEDY)
    return Scene(
        name=listed.name,
        dataset=listed.dataset,
        folder=folder,
        names=names,
        cameras=cameras_of(model),
        test=np.array(sorted(names.index(name) for name in listed.test), dtype=np.int64),
        points=points_of(model),
        extent=listed.extent,
        to_capture=listed.to_capture,
        source=listed.source,
        licence=listed.licence,
        content_hash=listed.content_hash,
        hashes=tuple(listed.images[name] for name in names),
        notes=tuple(listed.notes),
    )


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


def _write_geometry(
    folder: Path,
    names: Sequence[str],
    cameras: Cameras,
    points: Points,
    depth: Iterable[npt.NDArray[np.float32]] | None,
    mesh: Path | None,
    to_capture: Similarity,
) -> None:
    """Write the model, and the depths and the mesh, which are the capture's, in the unit and origin of the scene."""
    write_model(folder / "sparse" / "0", as_model(names, cameras, points))
    if depth is not None:
        _write_depth(folder / "depth", names, depth, to_capture.scale)
    if mesh is not None:
        write_moved_mesh(mesh, folder / "mesh.ply", to_capture)


def _write_depth(folder: Path, names: Sequence[str], depth: Iterable[npt.NDArray[np.float32]], unit: float) -> None:
    """Write the depths divided by ``unit``, that of the scene."""
    for name, distances in zip(names, depth, strict=True):
        path = folder / PurePosixPath(name).with_suffix(".npy")
        path.parent.mkdir(parents=True, exist_ok=True)
        np.save(path, (np.asarray(distances, dtype=np.float64) / unit).astype(np.float32), allow_pickle=False)


def _hashes_beside_images(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of every file of a scene but its images, by its name in the scene's folder."""
    paths = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    return {name: file_hash(path) for name, path in paths.items() if not name.startswith("images/")}


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
