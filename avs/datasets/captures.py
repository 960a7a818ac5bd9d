"""Captures: any folder in COLMAP layout, ``images/`` and ``sparse/0``, becomes a scene.

A scene has PINHOLE cameras. Cameras of other models are undistorted as COLMAP's ``image_undistorter`` does it, without
blank pixels; those whose distortion is zero keep their pixels. Every image may have its own intrinsics and size.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal, Self

import numpy as np
from pydantic import Field

from avs.datasets.capture_consistency import consistency_notes, unseen_notes
from avs.datasets.capture_depths import check_depths
from avs.datasets.capture_folders import capture_files, find_captures, photographs_key
from avs.datasets.capture_models import ChosenModel, choose_model
from avs.datasets.capture_pictures import Picture, picture_notes, plan_pictures, unique_names
from avs.datasets.capture_repeats import Repeats, find_repeats, repeat_notes, without
from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.reader import Reader
from avs.scene.cameras import Cameras, IndexArray
from avs.scene.colmap import NO_POINT, Model, find_model
from avs.scene.colmap.conversion import cameras_of, points_of, sorted_images
from avs.scene.images import Pixels, read_image
from avs.scene.pixel_forms import Color
from avs.scene.points import Points
from avs.scene.scene import write_scene
from avs.system.errors import UserError
from avs.system.reasons import Reason


class Captures(Reader, CaptureSettings):
    """Captures in a folder of the user's."""

    source: Literal["captures"] = Field(default="captures", description="captures in COLMAP layout")
    folder: str | None = Field(
        default=None, description="folder of captures, or one capture; null where the option scenes_dir gives it"
    )

    def scenes(self) -> dict[str, Self]:
        """Return the settings of each capture, by its name in lower case, in order; see ``find_captures``."""
        if self.folder is None:
            raise UserError("captures", "no folder is given", "add --config scenes_dir=DIR, or name a folder")
        found = find_captures(Path(self.folder)).folders
        return {name: self.model_copy(update={"folder": str(path)}) for name, path in found.items()}

    def left_out(self) -> dict[str, Reason]:
        """Return why a capture of the folder is not used, by the name of its folder."""
        return {} if self.folder is None else find_captures(Path(self.folder)).left_out

    def on_background(self, color: Color) -> Self:
        """Return settings with ``color`` behind transparent pixels, unless they name one."""
        return self if self.background is not None else self.model_copy(update={"background": color})

    def files(self) -> list[Path]:
        """Return every file that the capture may be read from."""
        return capture_files(self._folder)

    def identity(self) -> tuple[object, ...]:
        """Return what tells its photographs from those of others: a copy is the same scene."""
        key = photographs_key(self._folder)
        return (self.source, str(self._folder.resolve()) if key is None else key)

    def prepare(self, dataset: str, folder: Path) -> None:
        """Turn the capture into a scene; see ``prepare`` of this module."""
        prepare(self._folder, folder, self, dataset)

    @property
    def _folder(self) -> Path:
        return Path(self.folder or ".")


READER = Captures


def prepare(source: Path, folder: Path, settings: CaptureSettings, dataset: str = "captures") -> None:
    """Turn the capture in ``source`` into a scene of ``dataset`` in ``folder``, named after ``folder``.

    Only registered images are used. Every ``settings.test_every``-th of them by name, from the first on, is a test
    image.

    Raises:
        UserError: the model or an image is missing or damaged, or they contradict one another.
    """
    source, folder = Path(source), Path(folder)
    chosen = choose_model(source)
    repeats = _write(source, folder, settings, dataset, chosen, Repeats())
    if repeats.names:  # rare, so that a second writing costs less than a look at all pixels before
        _write(source, folder, settings, dataset, chosen, repeats)


def _write(
    source: Path, folder: Path, settings: CaptureSettings, dataset: str, chosen: ChosenModel, repeats: Repeats
) -> Repeats:
    """Write the scene without the images that ``repeats`` names; return those that are others once more."""
    model = without(chosen.model, repeats.names)
    images = sorted_images(model)
    pictures = plan_pictures(source, find_model(chosen.folder)[0], model.cameras, images, settings)
    check_depths(source, pictures)
    cameras = _cameras(model, pictures)
    observed = points_of(model)
    points = _visible(observed, cameras)
    names = unique_names(pictures)
    order = sorted(range(len(names)), key=names.__getitem__)
    places = np.argsort(order)
    hashes = write_scene(
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
        notes=[
            *chosen.notes,
            *repeat_notes(repeats),
            *picture_notes(source, pictures, settings, len(repeats.names)),
            *consistency_notes(model),
            *unseen_notes(names, observed, points),
            *_notes(model, points),
        ],
        cut_out=[name for name, picture in zip(names, pictures, strict=True) if picture.header.transparent],
    )

    def read(index: int) -> Pixels:
        return read_image(folder / "images" / names[index])

    return find_repeats([image.name for image in images], [hashes[name] for name in names], cameras, read)


def _cameras(model: Model, pictures: list[Picture]) -> Cameras:
    """Return the cameras of the scene's images, in the order of the pictures."""
    images = {row: replace(image, camera_id=row) for row, image in enumerate(sorted_images(model))}
    straight = {row: picture.straight for row, picture in enumerate(pictures)}
    sizes = np.array([picture.size for picture in pictures], dtype=np.int64)
    return cameras_of(replace(model, cameras=straight, images=images)).resized(sizes)


def _visible(points: Points, cameras: Cameras) -> Points:
    """Leave out observations behind the camera or in it, and outside the image, which undistortion may have cut."""
    rows, images = points.observations.T
    local = np.einsum("oij,oj->oi", cameras.world_to_camera[images, :3, :3], points.positions[rows])
    local += cameras.world_to_camera[images, :3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = np.einsum("oij,oj->oi", cameras.intrinsics[images], local / local[:, 2:])[:, :2]
    # float64 holds no more of where a point lies that is as far from the origin as this.
    nearest = 1e-15 * np.abs(points.positions[rows]).max(axis=1, initial=0.0)
    seen = (local[:, 2] > nearest) & (pixels >= 0).all(axis=1) & (pixels < cameras.sizes[images]).all(axis=1)
    return replace(points, observations=points.observations[seen])


def _reordered(points: Points, places: IndexArray) -> Points:
    """Return ``points`` after image i has become image ``places[i]``."""
    rows, images = points.observations.T
    observations = np.stack([rows, places[images]], axis=1)
    return replace(points, observations=np.unique(observations, axis=0))


def _notes(model: Model, points: Points) -> list[str]:
    """Return what a reader should know of the points."""
    notes = []
    if model.dropped:
        kept = sum(int((image.points != NO_POINT).sum()) for image in model.images.values())
        told = f"{model.dropped} of {model.dropped + kept} observations are left out"
        notes.append(f"{told}: they are of points that the model does not hold")
    if not len(points):
        return [*notes, "the model has no points"]
    if not len(points.observations):
        notes.append("no image observes a point of the model")
    return notes
