"""Map-Free Relocalisation (Arnold et al., ECCV 2022): videos of outdoor places by phone, 540 x 960, with poses.

A scene is a folder ``s00000`` with ``intrinsics.txt``, ``poses.txt`` and the videos' frames in ``seq0`` and ``seq1``.
Points are triangulated with the poses given: the data set has none.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, PositiveInt

from avs.datasets.capture_folders import Layout, is_folder
from avs.datasets.folder_reader import PictureFolderReader
from avs.datasets.found_points import triangulated_points
from avs.datasets.number_lines import TextLine, numbers_of, text_lines
from avs.datasets.posed_scene import PosedPictures
from avs.scene.colmap import Model, ModelCamera, ModelImage
from avs.scene.colmap.model import check_camera, check_pose
from avs.system.errors import UserError
from avs.system.lists_of_names import some_of
from avs.system.models import Different

_LICENCE = "Niantic's terms for Map-Free Relocalisation, for research alone, no redistribution"
_POSES, _INTRINSICS = "poses.txt", "intrinsics.txt"
_COPY = "get the archive again"

TRAINING, EVALUATION = 348, 11
"""Scenes that the paper trains and evaluates on, drawn at random from the 460 with poses; it does not list them."""


class MapFree(PictureFolderReader):
    """Scenes of Map-Free Relocalisation in a folder of the user's."""

    source: Literal["map_free"] = Field(default="map_free", description="Map-Free Relocalisation")
    folder: str = Field(description="the folder train (or val) of the data set, or that of one scene")
    sequences: Annotated[tuple[Literal["seq0", "seq1"], ...], Different] = Field(
        default=("seq0",), min_length=1, description="videos of each scene; both are in one frame of coordinates"
    )
    every: PositiveInt = Field(default=1, description="every n-th frame of these is used, from the first on")
    long_side: PositiveInt | None = Field(default=960, description="longer side in pixels; the paper's is 960")

    @classmethod
    def layout(cls) -> Layout:
        """Return how a scene's folder is told from others."""
        return Layout(_holds, _files, _frames, f"{_POSES} and {_INTRINSICS}")

    def posed(self) -> PosedPictures:
        """Return the frames of a scene's videos.

        Raises:
            UserError: a file is missing or damaged, or the poses are those of the test split, which has none.
        """
        cameras = read_intrinsics(self.place / _INTRINSICS)
        posed = read_poses(self.place / _POSES)
        images = self._chosen(posed)
        identifiers: dict[ModelCamera, int] = {}
        registered = {}
        for number, image in enumerate(images, 1):
            if image.name not in cameras:
                raise UserError(self.place / _INTRINSICS, f"has no line for {image.name}", _COPY)
            camera = identifiers.setdefault(cameras[image.name], len(identifiers) + 1)
            registered[number] = ModelImage(
                image.name, camera, image.quaternion, image.translation, image.keypoints, image.points
            )
        return PosedPictures(
            subject=f"Map-Free Relocalisation {self.place.resolve().name}",
            licence=_LICENCE,
            root=self.place,
            camera_file=self.place / _INTRINSICS,
            model=Model({identifier: camera for camera, identifier in identifiers.items()}, registered),
            notes=(
                f"{len(images)} frames of {', '.join(self.sequences)}, every {self.every}",
                *self._without_pose({image.name for image in posed}),
            ),
            find_points=triangulated_points,
        )

    def _without_pose(self, known: Collection[str]) -> list[str]:
        """Return the note on frames that the file of poses does not name, if there are any."""
        frames = [path.relative_to(self.place).as_posix() for path in _frames(self.place)]
        wanted = [name for name in frames if name.partition("/")[0] in self.sequences]
        lost = [name for name in wanted if name not in known]
        return [f"{len(lost)} of {len(wanted)} frames have no pose ({some_of(lost)})"] if lost else []

    def _chosen(self, images: Sequence[ModelImage]) -> list[ModelImage]:
        """Return the images of the sequences, by name, every n-th of them."""
        path = self.place / _POSES
        named = [image for image in images if image.name.partition("/")[0] in self.sequences]
        if len(named) < 2:
            fault = f"has {len(named)} poses of {', '.join(self.sequences)}"
            raise UserError(path, fault, "take other sequences, or the scenes of train")
        if not any(image.quaternion.any() for image in named):
            raise UserError(path, "has no poses, as the test split", "take the scenes of train or val")
        for image in named:
            if not image.quaternion.any():
                raise UserError(path, f"the pose of {image.name} is all zero", "take the scenes of train or val")
            check_pose(path, image)
        return sorted(named, key=lambda image: image.name)[:: self.every]


READER = MapFree


def read_poses(path: Path) -> list[ModelImage]:
    """Return the images of ``poses.txt``: a path, a quaternion with w first, and a translation, from world to camera.

    Lines with ``#`` are not read. Poses are not checked.

    Raises:
        UserError: the file is missing or damaged, or names a frame twice.
    """
    images = []
    for line in _named(path):
        numbers = numbers_of(line, line.words[1:], 7, _COPY)
        empty = np.zeros((0, 2)), np.zeros(0, dtype=np.int64)
        images.append(ModelImage(line.words[0], 0, np.array(numbers[:4]), np.array(numbers[4:]), *empty))
    return images


def read_intrinsics(path: Path) -> dict[str, ModelCamera]:
    """Return the cameras of ``intrinsics.txt`` by frame: a path, fx, fy, cx, cy, width and height in pixels.

    Raises:
        UserError: the file is missing or damaged, or names a frame twice.
    """
    cameras = {}
    for number, line in enumerate(_named(path), 1):
        *params, width, height = numbers_of(line, line.words[1:], 6, _COPY)
        camera = ModelCamera("PINHOLE", round(width), round(height), tuple(params))
        check_camera(path, number, camera)
        cameras[line.words[0]] = camera
    return cameras


def drawn_split(names: Sequence[str], seed: int) -> tuple[list[str], list[str]]:
    """Return names of scenes for training and for evaluation, as many as the paper has of each, in ascending order.

    The order of drawing is that of a hash of seed and name: the same on every machine, and a name more or less moves
    none of the others.
    """
    order = sorted(names, key=lambda name: hashlib.sha256(f"{seed} {name}".encode()).hexdigest())
    return sorted(order[:TRAINING]), sorted(order[TRAINING : TRAINING + EVALUATION])


def _named(path: Path) -> list[TextLine]:
    """Return the lines of a file that starts each with a frame, without those with ``#``."""
    lines = [line for line in text_lines(path, _COPY) if "#" not in line.text]
    names = set()
    for line in lines:
        if line.words[0] in names:
            raise UserError(path, f"names {line.words[0]} twice", _COPY)
        names.add(line.words[0])
    return lines


def _holds(path: Path) -> bool:
    return is_folder(path) and (path / _POSES).exists()


def _files(folder: Path) -> list[Path]:
    texts = [path for path in (folder / _INTRINSICS, folder / _POSES) if path.is_file()]
    return [*texts, *_frames(folder)]


def _frames(folder: Path) -> list[Path]:
    return sorted(folder.glob("seq[01]/*.jpg"))
