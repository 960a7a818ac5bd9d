"""From plain photographs, or a video, to a capture: poses found by structure from motion, in COLMAP's layout."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Literal

from PIL import Image

from avs.datasets.capture_folders import walk_files
from avs.datasets.capture_pictures import is_image
from avs.datasets.video_frames import every_frame
from avs.scene.images import read_header
from avs.system.errors import UserError
from avs.system.files import atomic_folder
from avs.system.lists_of_names import some_of

Lens = Literal["SIMPLE_PINHOLE", "SIMPLE_RADIAL", "OPENCV", "OPENCV_FISHEYE"]

_FEWEST = 3
_JPEG = 95
"""Quality of the frames of a video."""


def write_capture(
    source: Path, out: Path, *, lens: Lens, ordered: bool, rate: float, tell: Callable[[str], None]
) -> None:
    """Write a capture with the poses of the photographs in ``source``, whole or not at all.

    Photographs of one size are taken to share one camera.

    Args:
        source: a folder of photographs, in subfolders too, or a video.
        out: the capture: ``images`` with the photographs as they are, and ``sparse/0``; it must not exist.
        lens: COLMAP's model of the camera.
        ordered: whether the photographs follow a path by their names; frames of a video do.
        rate: frames of a video that are taken a second.
        tell: receives a line for each step, and at the end how many photographs have a pose.

    Raises:
        UserError: there are too few photographs, one is damaged, or no poses are found.
    """
    from avs.sfm.free_mapping import map_photographs

    if out.exists():
        raise UserError(out, "is there already", "name another folder, or take it away")
    is_video = source.is_file()
    with atomic_folder(out) as temporary:
        images = temporary / "images"
        (_extract if is_video else _copy)(source, images, rate, tell)
        names = [path.relative_to(images).as_posix() for path in walk_files(images)]
        if len(names) < _FEWEST:
            raise UserError(source, f"holds {len(names)} photographs, fewer than {_FEWEST}", "take more of them")
        sizes = {read_header(images / name).size for name in names}
        models = map_photographs(
            images,
            names,
            temporary / "sparse",
            lens=lens,
            one_camera=len(sizes) == 1,
            ordered=ordered or is_video,
            tell=tell,
        )
        if not models:
            remedy = "take photographs that overlap by two thirds, sharp, of something with texture, from other places"
            raise UserError(source, f"no two of its {len(names)} photographs could be placed", remedy)
    lost = sorted(set(names) - set(models[0].registered))
    told = f"{len(models[0].registered)} of {len(names)} photographs have a pose, with {models[0].points} points"
    tell(f"{out}: {told} and a mean reprojection error of {models[0].error:.2f} pixels")
    if lost:
        tell(f"without a pose: {some_of(lost, 5)}")
    if len(models) > 1:
        tell(f"{len(models)} models do not connect; the largest, sparse/0, is used")


def _copy(source: Path, images: Path, rate: float, tell: Callable[[str], None]) -> None:
    """Copy the photographs of a folder, after a look at each; ``rate`` is for videos."""
    if not source.is_dir():
        raise UserError(source, "there is no such folder or video", "give a folder of photographs, or a video")
    found = sorted(path for path in walk_files(source) if is_image(path))
    for path in found:
        read_header(path)
        target = images / path.relative_to(source)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)
    images.mkdir(exist_ok=True)
    tell(f"{len(found)} photographs in {source}")


def _extract(source: Path, images: Path, rate: float, tell: Callable[[str], None]) -> None:
    """Write the frames of a video."""
    images.mkdir()
    count = 0
    for _, pixels in every_frame(source, rate):
        Image.fromarray(pixels).save(images / f"frame_{count:05d}.jpg", quality=_JPEG, subsampling=0)
        count += 1
    tell(f"{count} frames of {source}, {rate:g} a second")
