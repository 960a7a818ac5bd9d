"""From plain photographs, or a video, to a capture: poses found by structure from motion, in COLMAP's layout."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Literal

from PIL import Image

from avs.datasets.image_names import is_image
from avs.datasets.photograph_origin import NAME, Origin, check_origin, files_in, files_made, origin_of, photographs_in
from avs.datasets.video_frames import every_frame
from avs.scene.images import read_header, read_image
from avs.system.errors import UserError
from avs.system.file_walk import walk_files
from avs.system.files import atomic_folder
from avs.system.lists_of_names import some_of
from avs.system.records import write_record

Lens = Literal["SIMPLE_PINHOLE", "SIMPLE_RADIAL", "OPENCV", "OPENCV_FISHEYE"]

_FEWEST = 3
_JPEG = 95
"""Quality of the frames of a video."""

_UNREAD = (".heic", ".heif", ".avif", ".dng", ".cr2", ".cr3", ".nef", ".arw")
"""Suffixes of photographs that Pillow does not open by itself, or not as they look."""


def write_capture(
    source: Path, out: Path, *, lens: Lens, ordered: bool, rate: float, tell: Callable[[str], None]
) -> None:
    """Write a capture with the poses of the photographs in ``source``, whole or not at all.

    Photographs of one size are taken to share one camera. What the capture is made of is kept in it
    (``avs.datasets.photograph_origin``); one that was made of the same before, with the same options, stays as it is.

    Args:
        source: a folder of photographs, in subfolders too, or a video.
        out: the capture: ``images`` with the photographs as they are, and ``sparse/0``; if it lies in ``source``, its
            own pictures do not count.
        lens: COLMAP's model of the camera.
        ordered: whether the photographs follow a path by their names; frames of a video do.
        rate: frames of a video that are taken a second.
        tell: receives a line for each step, and at the end how many photographs have a pose.

    Raises:
        UserError: there are too few photographs, one is damaged, no poses are found, or the capture is there and was
            made of something else.
    """
    _check_source(source, out)
    origin = origin_of(source, out, lens=lens, ordered=ordered, rate=rate)
    if out.exists():
        check_origin(out, origin)
        tell(f"{out}: is there already, made of the same as now; it is used as it is")
        return
    with atomic_folder(out) as temporary:
        images = temporary / "images"
        if source.is_file():
            _extract(source, images, rate, tell)
        else:
            found = photographs_in(source, out)
            _tell_of_unread(source, out, bool(found), tell)
            _copy(source, found, images, tell)
        told = _map(source, temporary, origin, tell)
        if origin_of(source, out, lens=lens, ordered=ordered, rate=rate) != origin:
            raise UserError(source, "changed while its poses were found", "run again")
        write_record(temporary / NAME, origin.model_copy(update={"made": files_made(temporary)}))
    tell(f"{out}: {told[0]}")
    for line in told[1:]:
        tell(line)


def _map(source: Path, capture: Path, origin: Origin, tell: Callable[[str], None]) -> list[str]:
    """Write ``sparse`` beside the ``images`` of a capture, and return what was found, in lines."""
    from avs.sfm.free_mapping import map_photographs

    images = capture / "images"
    names = [path.relative_to(images).as_posix() for path in walk_files(images)]
    if len(names) < _FEWEST:
        raise UserError(source, f"holds {len(names)} photographs, fewer than {_FEWEST}", "take more of them")
    sizes = {read_header(images / name).size for name in names}
    models = map_photographs(
        images,
        names,
        capture / "sparse",
        lens=origin.lens,
        one_camera=len(sizes) == 1,
        ordered=origin.ordered,
        tell=tell,
    )
    if not models:
        remedy = "take photographs that overlap by two thirds, sharp, of something with texture, from other places"
        raise UserError(source, f"no two of its {len(names)} photographs could be placed", remedy)
    best = models[0]
    told = f"{len(best.registered)} of {len(names)} photographs have a pose, with {best.points} points"
    lines = [f"{told} and a mean reprojection error of {best.error:.2f} pixels"]
    if lost := sorted(set(names) - set(best.registered)):
        lines.append(f"without a pose: {some_of(lost, 5)}")
    if len(models) > 1:
        lines.append(f"{len(models)} models do not connect; the largest, sparse/0, is used")
    return lines


def _check_source(source: Path, out: Path) -> None:
    """See that the source may be one of photographs, before any is read."""
    if source.is_file() and is_image(source):
        raise UserError(source, "is a single picture", "give the folder with all photographs, or a video")
    if not source.exists():
        raise UserError(source, "there is no such folder or video", "give a folder of photographs, or a video")
    if source.resolve().is_relative_to(out.resolve()):
        raise UserError(source, f"lies in {out}, the capture to be made of it", "name another folder for the capture")


def _tell_of_unread(source: Path, out: Path, are_others: bool, tell: Callable[[str], None]) -> None:
    """Tell of pictures as phones and cameras save them that are not read, and refuse a folder of these alone."""
    unread = files_in(source, out, lambda path: path.suffix.lower() in _UNREAD)
    if not unread:
        return
    forms = ", ".join(sorted({path.suffix.lower() for path in unread}))
    remedy = "convert them to JPEG, or let the camera save JPEG"
    if not are_others:
        raise UserError(source, f"holds {len(unread)} pictures of a form that is not read ({forms})", remedy)
    tell(f"{len(unread)} pictures of a form that is not read ({forms}) are left out: {remedy}")


def _copy(source: Path, found: list[Path], images: Path, tell: Callable[[str], None]) -> None:
    """Copy the photographs of a folder, after a look at all pixels of each: COLMAP passes over a damaged one."""
    for path in found:
        read_image(path)
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
