"""RealEstate10K (Zhou et al., SIGGRAPH 2018): walks through houses, as poses of frames of videos that the reader has.

The data set is text: ``<id>.txt`` has the address of a video, and a line for each frame with its time in microseconds,
focal lengths and principal point as shares of width and height, two zeros, and a 3 x 4 world-to-camera matrix. Videos
are found by their identifier on the site of the address, as in ``QShWPZxTDoE.mp4``, or by that of the text. Points are
triangulated with the poses given.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from PIL import Image
from pydantic import Field, PositiveFloat, PositiveInt

from avs.datasets.capture_folders import FoundCaptures, Layout
from avs.datasets.folder_reader import FolderReader
from avs.datasets.found_points import triangulated_points
from avs.datasets.number_lines import numbers_of, text_lines
from avs.datasets.posed_scene import PosedPictures, write_posed
from avs.datasets.published_archives import Archive
from avs.datasets.transforms_file import posed_image
from avs.datasets.video_frames import MICROSECONDS, frames_at
from avs.scene.cameras import FloatArray
from avs.scene.colmap import Model, ModelCamera
from avs.scene.colmap.model import check_camera
from avs.system.errors import UserError
from avs.system.file_walk import walk_files
from avs.system.files import explained, temporary_folder
from avs.system.lists_of_names import some_of
from avs.system.reasons import Reason

_COPY = "get the file again"
_LICENCE = "trajectories CC BY 4.0 (Google); the videos are their owners'"
_COLUMNS = 19


@dataclass(frozen=True)
class PosedFrames:
    """What a text of the data set says.

    Attributes:
        video: identifier of the video on the site of its address.
        times: microseconds from the video's start, ascending.
        intrinsics: ``[n, 4]`` focal lengths and principal point, x and y, in shares of width and height.
        world_to_camera: ``[n, 4, 4]``, OpenCV axes.
    """

    video: str
    times: tuple[int, ...]
    intrinsics: FloatArray
    world_to_camera: FloatArray


class RealEstate10K(FolderReader):
    """Scenes of RealEstate10K in a folder of the user's."""

    # the address that the page shows leads to a sign-in; this one does not
    archives = (Archive("https://storage.googleapis.com/realestate10k-public-files/RealEstate10K.tar.gz"),)

    source: Literal["realestate10k"] = Field(default="realestate10k", description="RealEstate10K")
    folder: str = Field(description="folder of the texts, or of train/ and test/ with them")
    videos: str = Field(description="folder of the videos")
    tolerance: PositiveFloat = Field(
        default=0.02, description="seconds between a pose's time and the frame taken for it, at most"
    )
    every: PositiveInt = Field(default=1, description="every n-th pose is used, from the first on")
    long_side: PositiveInt | None = Field(default=960, description="longer side in pixels; the paper's is 960")

    @classmethod
    def layout(cls) -> Layout:
        """Return how a text is told from others."""
        return Layout(_is_text, lambda path: [path], lambda _: [], "texts <id>.txt")

    def left_out(self) -> dict[str, Reason]:
        """Return why a text is no scene, by its name, and which scenes that should be there are not."""
        told = self._found().left_out
        named = {_scene_name(Path(name)) for name in told}
        return told | {name: reason for name, reason in super().left_out().items() if name not in named}

    def files(self) -> list[Path]:
        """Return the text and the video."""
        video = self._video()
        return [self.place] if video is None else [self.place, video]

    def identities(self) -> tuple[tuple[object, ...], ...]:
        """Return the place of the text, the clip, and the video that it is a part of."""
        key = _key(self.place)
        return (("place", str(self.place.resolve())), key, ("video", key[1]))

    def prepare(self, dataset: str, folder: Path) -> None:
        """Turn the frames that the text names into a scene.

        Raises:
            UserError: the text is damaged, or the video is missing, cannot be decoded, or lacks the frames.
        """
        with temporary_folder("avs-frames-") as frames:
            write_posed(self._extracted(frames), folder, self, dataset)

    def examine(self) -> str:
        """Return how many frames the text names; that the video is there is all that is looked at."""
        told = read_posed_frames(self.place)
        return f"{len(told.times)} frames with poses, video {self._found_video(told).name}"

    def _extracted(self, frames: Path) -> PosedPictures:
        """Write the frames that the text names to a folder, and return them with their poses."""
        told = read_posed_frames(self.place)
        video = self._found_video(told)
        rows = range(0, len(told.times), self.every)
        times = [told.times[row] for row in rows]
        found = {}
        for position, pixels in frames_at(video, times, round(self.tolerance * MICROSECONDS)):
            name = f"{times[position]:012d}.png"
            Image.fromarray(pixels).save(frames / name, compress_level=1)
            found[rows[position]] = (name, pixels.shape[1], pixels.shape[0])
        if len(found) < 2:
            fault = f"has {len(found)} of the {len(times)} frames that {self.place.name} names"
            raise UserError(video, fault, "get the video of that address, whole, or raise the tolerance")
        return PosedPictures(
            subject=f"RealEstate10K {self.place.stem}, video {told.video}",
            licence=_LICENCE,
            root=frames,
            camera_file=self.place,
            model=_model(self.place, told, found),
            notes=tuple(self._notes(len(times), len(found))),
            find_points=triangulated_points,
        )

    def _found_video(self, told: PosedFrames) -> Path:
        video = self._video()
        if video is None:
            raise UserError(self.videos, f"holds no video {told.video}", "get it, or leave the scene out")
        return video

    def _notes(self, wanted: int, found: int) -> list[str]:
        lost = wanted - found
        told = f"{lost} of {wanted} frames are left out: the video has none within {self.tolerance:g} s of their times"
        return [told] if lost else []

    def _video(self) -> Path | None:
        """Return the video of this scene, or None where it is not there or the text cannot be read."""
        videos = _videos(Path(self.videos))
        return videos.get(_identifier(self.place) or "") or videos.get(self.place.stem)

    def _found(self) -> FoundCaptures:
        """Return the texts by scene name: all that ``only`` names, or those whose videos are there."""
        with explained():
            if _is_text(self.place):
                return FoundCaptures({_scene_name(self.place): self.place}, {})
            wanted = self._wanted_texts()
            videos = _videos(Path(self.videos))
            there = [path for path in wanted if _identifier(path) in videos or path.stem in videos]
            folders, left_out = self._told_apart(there)
        lacking = {_scene_name(path): _identifier(path) or path.stem for path in wanted if path not in there}
        if not there:
            fault = f"holds no video of the {len(wanted)} wanted texts in {self.place} ({some_of([*lacking.values()])})"
            raise UserError(self.videos, fault, "put the videos there, each called after its identifier")
        lost = {
            name: Reason(cause=f"lacks its video, {video}", remedy=f"put it into {self.videos}")
            for name, video in lacking.items()
            if name not in folders and self.only is not None
        }
        return FoundCaptures(folders, lost | left_out)

    def _wanted_texts(self) -> list[Path]:
        """Return the texts that ``only`` names, or all; of two with one scene name, that which has it is the first."""
        if not self.place.is_dir():
            raise UserError(self.place, "there is no such folder", "give the folder of the texts")
        found = [path for part in (".", "train", "test") for path in sorted((self.place / part).glob("*.txt"))]
        texts = [path for path in found if _is_text(path)]
        if not texts:
            raise UserError(
                self.place, "holds no texts <id>.txt, nor does train or test in it", "give the folder of the texts"
            )
        wanted = [path for path in texts if self.only is None or _scene_name(path) in self.only]
        if not wanted:
            fault = f"holds none of the texts that `only` names ({some_of(self.only or ())})"
            raise UserError(self.place, fault, "name some that are there, or get the others")
        return sorted(wanted, key=lambda path: (path.is_symlink(), path.stem != _scene_name(path)))

    def _told_apart(self, texts: list[Path]) -> tuple[dict[str, Path], dict[str, Reason]]:
        """Return the texts by scene name, and why others of them are left out: a clip does not count twice."""
        folders: dict[str, Path] = {}
        left_out = {}
        keys: dict[tuple[object, ...], Path] = {}
        for path in texts:
            name, shown = _scene_name(path), path.relative_to(self.place).as_posix()
            first = keys.setdefault(_key(path), path)
            if first != path:
                cause = f"is the same clip as {first.relative_to(self.place).as_posix()}"
                left_out[shown] = Reason(cause=cause, remedy="take one away")
            elif name in folders:
                other = folders[name].relative_to(self.place).as_posix()
                left_out[shown] = Reason(cause=f"has the same scene name, {name}, as {other}", remedy="rename one")
            else:
                folders[name] = path
        return dict(sorted(folders.items())), left_out


READER = RealEstate10K


def read_posed_frames(path: Path) -> PosedFrames:
    """Read a text of the data set.

    Raises:
        UserError: it is missing or damaged, or has a time twice.
    """
    found = text_lines(path, _COPY)
    if len(found) < 2:
        raise UserError(path, "has no frames", _COPY)
    first, *lines = found
    table = np.array([numbers_of(line, line.words, _COLUMNS, _COPY) for line in lines])
    if not (table[:, 5:7] == 0).all():
        raise UserError(path, "has other columns than RealEstate10K: the sixth and seventh are not zero", _COPY)
    if not (np.diff(table[:, 0]) > 0).all():
        raise UserError(path, "has times that do not ascend, or one twice", _COPY)
    matrices = np.tile(np.eye(4), (len(lines), 1, 1))
    matrices[:, :3] = table[:, 7:].reshape(-1, 3, 4)
    video = _identifier_in(first.text)
    if video is None:
        raise UserError(path, f"its first line is no address of a video: '{first.text[:60]}'", _COPY)
    return PosedFrames(video, tuple(int(time) for time in table[:, 0]), table[:, 1:5], matrices)


def _model(path: Path, told: PosedFrames, found: dict[int, tuple[str, int, int]]) -> Model:
    """Return the cameras and poses of the frames that were found: name, width and height by row of the text."""
    cameras: dict[ModelCamera, int] = {}
    images = {}
    for row, (name, width, height) in found.items():
        params = told.intrinsics[row] * (width, height, width, height)
        camera = ModelCamera("PINHOLE", width, height, tuple(map(float, params)))
        identifier = cameras.setdefault(camera, len(cameras) + 1)
        check_camera(path, identifier, camera)
        if not told.world_to_camera[row, :3, :3].any():
            raise UserError(path, f"the pose at {told.times[row]} is all zero", "take the line out")
        images[row + 1] = posed_image(path, name, identifier, told.world_to_camera[row])
    return Model({identifier: camera for camera, identifier in cameras.items()}, images)


def _is_text(path: Path) -> bool:
    return path.suffix == ".txt" and path.is_file()


def _key(path: Path) -> tuple[object, ...]:
    """Return what tells a clip from others: its video, and the hash of its lines, however blanks are set."""
    first, _, lines = path.read_bytes().partition(b"\n")
    video = _identifier_in(first.decode(errors="replace")) or path.stem
    return ("clip", video, hashlib.sha256(b" ".join(lines.split())).hexdigest())


def _scene_name(path: Path) -> str:
    return re.sub("[^a-z0-9_]", "_", path.stem.lower())


def _videos(folder: Path) -> dict[str, Path]:
    """Return the videos in a folder and its subfolders by their names without suffix; texts and pictures are none.

    Raises:
        UserError: two have one name; their frames need not be those of one time.
    """
    others = {".txt", ".json", ".jpg", ".png", ".webp", ".part", ".vtt", ".description"}
    found: dict[str, Path] = {}
    for path in walk_files(folder):
        if path.suffix.lower() not in others and found.setdefault(path.stem, path) != path:
            fault = f"is a second video of the name {path.stem}, beside {found[path.stem]}"
            raise UserError(path, fault, "take one away")
    return found


def _identifier(path: Path) -> str | None:
    """Return the identifier of the video of a text, or None where its first line has none."""
    with open(path, encoding="utf-8", errors="replace") as stream:
        return _identifier_in(stream.readline(1000))


def _identifier_in(address: str) -> str | None:
    found = re.search(r"(?:[?&]v=|youtu\.be/)([\w-]+)", address)
    return None if found is None else found[1]
