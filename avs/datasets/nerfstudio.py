"""Captures in nerfstudio's form: ``transforms.json`` with cameras and poses, and the pictures that it lists."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Literal

from pydantic import Field

from avs.datasets.camera_axes import showing, triangulating
from avs.datasets.capture_folders import Layout, is_folder
from avs.datasets.folder_reader import PictureFolderReader
from avs.datasets.posed_scene import PosedPictures
from avs.datasets.stored_points import read_ply
from avs.datasets.transforms_file import Axes, PixelCenters, Transforms, model_of, read_transforms
from avs.scene.images import read_header
from avs.system.errors import UserError

FILES = ("camera-rgb-rectified-*/transforms.json", "transforms.json", "camera-rgb-transforms.json")
"""Where the file of cameras lies in a scene's folder, the preferred place first."""


class TransformsReader(PictureFolderReader):
    """Captures with a file of cameras in nerfstudio's form."""

    folder: str = Field(description="folder of the captures' folders, or that of one capture")
    axes: Axes = Field(
        description="of the cameras whose poses the file states, which it does not tell: opengl (y up, z backwards; "
        "nerfstudio and what exports for it) or opencv (y down, z forwards; Meta's exports of Aria recordings)"
    )
    pixel_centers: PixelCenters = Field(
        default="half",
        description="the centre of the first pixel in the file's coordinates: half, (0.5, 0.5), as COLMAP and "
        "nerfstudio have it, or integer, (0, 0), as Aria's calibrations do",
    )
    points: Literal["triangulated", "stored"] = Field(
        default="triangulated",
        description="triangulated: found in the pictures with the poses given, each with the images that see it; "
        "stored: those of the file's ply_file_path, which come without",
    )

    @classmethod
    def layout(cls) -> Layout:
        """Return how a folder with a file of cameras is told from others."""
        return Layout(_holds, _files, _pictures, "a file transforms.json")

    def posed(self) -> PosedPictures:
        """Return the pictures that the file of cameras lists.

        Raises:
            UserError: a file is missing or damaged, or contradicts another.
        """
        transforms = read_transforms(_cameras_file(self.place))
        root = transforms.path.parent
        for name, _ in transforms.frames:
            if (root / name).is_dir():
                raise UserError(transforms.path, f"{name} is a folder, not a picture", "name the picture's file")
        sizes = {name: read_header(root / name).size for name, _ in transforms.frames}
        model = model_of(transforms, sizes, self.axes, self.pixel_centers)
        find = triangulating(transforms.path, self.axes)
        if self.points == "stored":
            if transforms.points is None:
                raise UserError(transforms.path, "names no cloud (ply_file_path)", "set points: triangulated")
            find = showing(transforms.path, self.axes, partial(read_ply, transforms.points))
        return PosedPictures(
            subject=f"capture {self.place.resolve().name}",
            licence=self.licence(),
            root=root,
            camera_file=transforms.path,
            model=model,
            notes=tuple(_size_notes(transforms, sizes)),
            listed=_beside(root, transforms),
            find_points=find,
        )

    def licence(self) -> str:
        """Return the terms of the pictures, one line."""
        return "as the capture's owner says"


class Nerfstudio(TransformsReader):
    """Captures in nerfstudio's form in a folder of the user's."""

    source: Literal["nerfstudio"] = Field(default="nerfstudio", description="captures with a transforms.json")


READER = Nerfstudio


def _cameras_file(folder: Path) -> Path:
    """Return the file of cameras in a scene's folder; where it should be if there is none.

    Raises:
        UserError: there are several in places of one rank.
    """
    for found in (sorted(folder.glob(pattern)) for pattern in FILES):
        if len(found) > 1:
            told = ", ".join(path.parent.name for path in found)
            raise UserError(folder, f"has several exports: {told}", "keep the one that is meant")
        if found:
            return found[0]
    return folder / "transforms.json"


def _beside(root: Path, transforms: Transforms) -> tuple[Path, ...]:
    """Return all files that lie where the listed pictures do: pictures among them may be left out of the list."""
    folders = sorted({(root / name).parent for name, _ in transforms.frames})
    return tuple(path for folder in folders if folder.is_dir() for path in sorted(folder.iterdir()))


def _holds(path: Path) -> bool:
    return is_folder(path) and any(next(path.glob(pattern), None) is not None for pattern in FILES)


def _pictures(folder: Path) -> list[Path]:
    """Return the pictures that the file of cameras lists and that are there; none if it cannot be read."""
    return _listed(folder)[1]


def _files(folder: Path) -> list[Path]:
    """Return the file of cameras, the pictures that it lists, and its cloud, as far as they are there."""
    clouds, pictures = _listed(folder)
    cameras = [path for pattern in FILES for path in sorted(folder.glob(pattern))]
    return [*cameras, *pictures, *clouds]


def _listed(folder: Path) -> tuple[list[Path], list[Path]]:
    """Return the cloud and the pictures that the file of cameras lists and that are there."""
    try:
        path = _cameras_file(folder)
        told = read_transforms(path)
    except UserError:  # the job that prepares the scene says so
        return [], []
    clouds = [told.points] if told.points is not None and told.points.is_file() else []
    return clouds, sorted(file for file in (path.parent / name for name, _ in told.frames) if file.is_file())


def _size_notes(transforms: Transforms, sizes: dict[str, tuple[int, int]]) -> list[str]:
    """Return the note on pictures of another size than the file says, if there are any."""
    odd = [
        (name, round(frame.w), round(frame.h))
        for name, frame in transforms.frames
        if frame.w is not None and frame.h is not None and (round(frame.w), round(frame.h)) != sizes[name]
    ]
    if not odd:
        return []
    name, width, height = odd[0]
    real = "x".join(map(str, sizes[name]))
    which = "all images" if len(odd) == len(transforms.frames) else f"{len(odd)} of {len(transforms.frames)} images"
    return [f"{which} have another size than {transforms.path.name} states, {real} and not {width}x{height}: scaled"]
