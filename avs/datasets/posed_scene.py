"""From pictures with poses to a scene: what every reader of photographs does once it knows cameras, poses and points.

A scene has PINHOLE cameras. Cameras of other models are undistorted as COLMAP's ``image_undistorter`` does it, without
blank pixels; those whose distortion is zero keep their pixels. Every image may have its own intrinsics and size.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from avs.datasets.capture_consistency import consistency_notes, unseen_notes
from avs.datasets.capture_depths import check_depths
from avs.datasets.capture_geometry import geometry_notes
from avs.datasets.capture_pictures import Picture, picture_notes, plan_pictures, unique_names
from avs.datasets.capture_repeats import Repeats, find_repeats, repeat_notes, without
from avs.datasets.capture_settings import CaptureSettings
from avs.scene.cameras import Cameras, IndexArray
from avs.scene.colmap import NO_POINT, Model
from avs.scene.colmap.conversion import cameras_of, points_of, sorted_images
from avs.scene.images import Pixels, read_image
from avs.scene.points import Points
from avs.scene.scene import write_scene
from avs.scene.views import Views
from avs.system.errors import UserError

FindPoints = Callable[[Views], tuple[Points, list[str]]]
"""Finds points that views with known poses see, and says what a reader of the scene should know of them. Observations
count the views in the order given."""


@dataclass(frozen=True)
class PosedPictures:
    """Pictures in files, with cameras, poses and points in any unit and origin.

    Attributes:
        subject: what messages and ``scene.json`` call them, one line, such as ``capture garden``.
        licence: their terms, one line.
        root: the folder that names of images start from.
        camera_file: the file of the cameras, for messages.
        model: cameras of any of COLMAP's models, poses, and the points that are known.
        notes: what a reader of the scene should know, such as which of several models is used.
        listed: files among which pictures may lie that are not used; a note counts them.
        find_points: finds the points where the model has none to offer; None to take the model's.
    """

    subject: str
    licence: str
    root: Path
    camera_file: Path
    model: Model
    notes: tuple[str, ...] = ()
    listed: tuple[Path, ...] = ()
    find_points: FindPoints | None = None


def write_posed(posed: PosedPictures, folder: Path, settings: CaptureSettings, dataset: str) -> None:
    """Write the scene of ``dataset`` that the pictures make to ``folder``, named after ``folder``.

    Every ``settings.test_every``-th image by name, from the first on, is a test image.

    Raises:
        UserError: an image is missing or damaged, or images and cameras contradict one another.
    """
    repeats = _write(posed, folder, settings, dataset, Repeats())
    if repeats.names:  # rare, so that a second writing costs less than a look at all pixels before
        _write(posed, folder, settings, dataset, repeats)


def _write(posed: PosedPictures, folder: Path, settings: CaptureSettings, dataset: str, repeats: Repeats) -> Repeats:
    """Write the scene without the images that ``repeats`` names; return those that are others once more."""
    model = without(posed.model, repeats.names)
    images = sorted_images(model)
    pictures = plan_pictures(posed.root, posed.camera_file, model.cameras, images, settings)
    check_depths(posed.root, pictures)
    cameras = _cameras(model, pictures)
    names = unique_names(pictures)
    points, notes = _points(posed, model, names, pictures, cameras, settings)
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
        source=posed.subject,
        licence=posed.licence,
        notes=[
            *posed.notes,
            *repeat_notes(repeats),
            *picture_notes(posed.listed, pictures, settings, len(repeats.names)),
            *notes,
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


def _points(
    posed: PosedPictures,
    model: Model,
    names: list[str],
    pictures: list[Picture],
    cameras: Cameras,
    settings: CaptureSettings,
) -> tuple[Points, list[str]]:
    """Return the points with what is seen of them in the pictures, and what a reader should know of them."""
    if posed.find_points is not None:
        if len(pictures) < 2:
            fault = f"leaves {len(pictures)} picture, of which no point can be triangulated"
            raise UserError(posed.camera_file, fault, "use two pictures or more")
        read = [picture.read(settings) for picture in pictures]
        pixels = tuple(read_image(image) if isinstance(image, Path) else image for image in read)
        views = Views(cameras, pixels, tuple(names))
        points, notes = posed.find_points(views)
        return _visible(points, cameras), [*notes, *geometry_notes(views, points.positions)]
    observed = points_of(model)
    points = _visible(observed, cameras)
    notes = [*consistency_notes(model), *unseen_notes(names, observed, points), *_notes(model, points)]
    return points, notes


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
