"""The images of a capture: what becomes of each, and what a reader of the scene should know of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np
from PIL import Image

from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.image_names import is_image
from avs.datasets.undistortion import pinhole, rescaled, undistorted_camera, undistorted_image
from avs.scene.colmap import ModelCamera, ModelImage
from avs.scene.images import BLACK, Header, Pixels, is_translucent, open_rgb, read_header
from avs.system.errors import UserError

_KEPT_SUFFIXES = {"JPEG": {".jpg", ".jpeg"}, "PNG": {".png"}}
_SAME_AREA = 1.25
"""Ratio of areas up to which pictures count as of one size."""
_FILTERS = {"pil": Image.Resampling.BICUBIC, "area": Image.Resampling.BOX}


@dataclass(frozen=True)
class Picture:
    """One registered image and what becomes of it.

    Attributes:
        name: its name in the model.
        path: its file.
        header: what the file says of itself.
        orientation: the EXIF orientation that has to be applied to agree with its camera; 1 for none.
        camera: its camera, of the file's pixels (turned).
        straight: the PINHOLE camera without distortion, before the image is resized.
        size: width and height in the scene.
        kept: whether the file goes into the scene as it is.
    """

    name: str
    path: Path
    header: Header
    orientation: int
    camera: ModelCamera
    straight: ModelCamera
    size: tuple[int, int]
    kept: bool

    def read(self, settings: CaptureSettings) -> Pixels | Path:
        """Return the pixels for the scene, or the file where it is kept."""
        if self.kept:
            return self.path
        image = open_rgb(self.path, self.orientation, settings.background or BLACK)
        if pinhole(self.camera) is None:
            image = Image.fromarray(undistorted_image(np.asarray(image), self.camera))
        if self.size != image.size:
            image = image.resize(self.size, _FILTERS[settings.resample])
        return np.array(image)

    def stored_name(self) -> str:
        """Return the name in the scene: images that change are stored as PNG."""
        return self.name if self.kept else str(PurePosixPath(self.name).with_suffix(".png"))


def plan_pictures(
    root: Path,
    camera_file: Path,
    cameras: dict[int, ModelCamera],
    images: Sequence[ModelImage],
    side: CaptureSettings,
) -> list[Picture]:
    """Decide what becomes of each image, from its header and its camera.

    Args:
        root: the folder that names of images start from.
        camera_file: file of the cameras, for messages.
        cameras: by identifier.
        images: the registered images.
        side: the size that images get.

    Raises:
        UserError: an image is missing, damaged, does not fit its camera, or is named twice.
    """
    pictures = [_plan(root, camera_file, cameras[image.camera_id], image, side) for image in images]
    names: dict[Path, str] = {}
    for picture in pictures:
        first = names.setdefault(picture.path, picture.name)
        if first != picture.name:
            fault = f"is two images of the model, {first} and {picture.name}"
            raise UserError(picture.path, fault, "run the structure from motion again")
    return pictures


def unique_names(pictures: Sequence[Picture]) -> list[str]:
    """Return the names in the scene; where two would be equal (a.jpg and a.bmp), they keep their old suffix too."""
    wanted = [picture.stored_name() for picture in pictures]
    counts = Counter(wanted)
    taken = {name for name, picture in zip(wanted, pictures, strict=True) if counts[name] == 1 or picture.kept}
    names = []
    for name, picture in zip(wanted, pictures, strict=True):
        if counts[name] > 1 and not picture.kept:
            name = f"{picture.name}.png"
            while name in taken:
                name += ".png"
            taken.add(name)
        names.append(name)
    return names


def picture_notes(
    listed: Collection[Path], pictures: Sequence[Picture], settings: CaptureSettings, repeats: int = 0
) -> list[str]:
    """Return what a reader should know: which images are left out, and what was done to the others.

    Args:
        listed: files among which images may lie that are not used.
        pictures: those that are.
        settings: how they become a scene.
        repeats: so many of those that are not used are registered: they are other images once more.
    """
    notes = []
    used = {picture.path for picture in pictures}
    present = {path for path in listed if is_image(path)}
    unregistered = len(present - used) - repeats
    if unregistered > 0:
        notes.append(f"{unregistered} of {len(present)} images are left out: the model does not register them")
    red, green, blue = settings.background or BLACK
    unturned = [picture for picture in pictures if picture.header.orientation != picture.orientation]
    for done, count in {
        "undistorted": sum(pinhole(picture.camera) is None for picture in pictures),
        f"composited on the background ({red:g}, {green:g}, {blue:g}), since they have transparency": sum(
            picture.header.transparent and is_translucent(picture.path) for picture in pictures
        ),
        "read with their first frame or page alone": sum(picture.header.frames for picture in pictures),
        "read as sRGB, though they have another colour profile": sum(picture.header.profile for picture in pictures),
        "read as they are stored, not as their EXIF orientation says, since so they fit their cameras": sum(
            not _fits_both_ways(picture) for picture in unturned
        ),
        "read as they are stored, as structure from motion does, though their EXIF orientation says otherwise and they "
        "would fit their cameras both ways: if the model was made of turned copies, give those": sum(
            map(_fits_both_ways, unturned)
        ),
        "read as they are stored, since their EXIF orientation makes no sense": sum(
            picture.header.odd for picture in pictures
        ),
    }.items():
        if count:
            which = "all images" if count == len(pictures) else f"{count} of {len(pictures)} images"
            notes.append(f"{which} are {done}")
    return [*notes, *_note_of_sizes(pictures)]


def _note_of_sizes(pictures: Sequence[Picture]) -> list[str]:
    """Tell of pictures of different areas, which decide where a score is a sum over pixels."""
    (low, small), *_, (high, large) = sorted((picture.size[0] * picture.size[1], picture.size) for picture in pictures)
    if high <= _SAME_AREA * low:
        return []
    sizes = " to ".join(f"{width} x {height}" for width, height in (small, large))
    return [f"pictures have {sizes} pixels: methods whose score is a sum over pixels or rays prefer the large ones"]


def _fits_both_ways(picture: Picture) -> bool:
    """Whether an image with an EXIF orientation has the shape of its camera as it is stored and turned by it, too."""
    return picture.header.orientation < 5 or _fits(picture.header.size[::-1], picture.camera)


def _plan(root: Path, cameras: Path, camera: ModelCamera, image: ModelImage, settings: CaptureSettings) -> Picture:
    """Look at an image's header and its camera and decide what becomes of it."""
    relative = PurePosixPath(image.name)
    if relative.is_absolute() or ".." in relative.parts or not relative.name:
        raise UserError(
            cameras.parent, f"image name {image.name} points outside the folder {root.name}", "rename the image"
        )
    if "\0" in image.name:
        raise UserError(cameras.parent, f"the image name {image.name} is no name of a file", "copy the model again")
    path = root / relative
    header = read_header(path)
    stored = header.size
    turned = header.orientation >= 5 and _fits(stored[::-1], camera) and not _fits(stored, camera)
    width, height = stored[::-1] if turned else stored
    if not _fits((width, height), camera):
        fault = f"the image is {width} x {height} pixels, its camera {camera.width} x {camera.height}"
        raise UserError(path, fault, "use the images that the model was made from")
    if (width, height) != (camera.width, camera.height):
        camera = rescaled(camera, width, height)
    straight = pinhole(camera) or undistorted_camera(camera)
    if straight is None:
        fault = f"camera {image.camera_id} ({camera.model}) cannot be undistorted"
        raise UserError(cameras, fault, "use images of a perspective or fisheye camera, or calibrate it again")
    size = settings.image_size(straight.width, straight.height)
    same = straight == pinhole(camera) and size == (width, height)
    kept = same and header.plain and path.suffix.lower() in _KEPT_SUFFIXES.get(header.form, ())
    return Picture(image.name, path, header, header.orientation if turned else 1, camera, straight, size, kept)


def _fits(size: tuple[int, int], camera: ModelCamera) -> bool:
    """Whether an image of ``size`` shows what ``camera`` does: same shape, up to the rounding of a resized side."""
    width, height = size
    return abs(width * camera.height - height * camera.width) <= max(camera.width, camera.height)
