"""Frames of videos, decoded by FFmpeg's libraries through PyAV."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from avs.scene.images import Pixels
from avs.system.errors import UserError
from avs.system.regular_files import check_regular

MICROSECONDS = 1_000_000

_EARLIER = 1_000_000
"""Microseconds before the first wanted time at which decoding starts, at the key frame before it."""


def frames_at(path: Path, times: Sequence[int], tolerance: int) -> Iterator[tuple[int, Pixels]]:
    """Yield the frame nearest to each time, where one is near enough.

    Args:
        path: the video.
        times: microseconds from the video's start, ascending.
        tolerance: microseconds between a time and its frame, at most.

    Yields:
        The index in ``times``, ascending, and the frame's pixels ``[height, width, 3]`` uint8 sRGB.

    Raises:
        UserError: the video is missing, or cannot be decoded up to the last time.
    """
    position, before = 0, None
    for moment, frame in _decoded(path, max(0, times[0] - _EARLIER)):
        while position < len(times) and moment >= times[position]:
            near = min(
                (each for each in (before, (moment, frame)) if each), key=lambda each: abs(each[0] - times[position])
            )
            if abs(near[0] - times[position]) <= tolerance:
                yield position, _pixels(near[1])
            position += 1
        if position == len(times):
            return
        before = (moment, frame)
    while before is not None and position < len(times) and times[position] - before[0] <= tolerance:
        yield position, _pixels(before[1])  # the video ends between two times
        position += 1


def every_frame(path: Path, rate: float) -> Iterator[tuple[int, Pixels]]:
    """Yield about ``rate`` frames of each second: the microsecond from the video's start, and the pixels.

    Raises:
        UserError: the video is missing, or cannot be decoded.
    """
    wanted = 0.0
    for moment, frame in _decoded(path, 0):
        if moment >= wanted:
            yield moment, _pixels(frame)
            wanted = max(wanted + MICROSECONDS / rate, moment)


def _decoded(path: Path, start: int) -> Iterator[tuple[int, Any]]:
    """Yield moment and frame of a video from the key frame at or before ``start``, in microseconds."""
    import av

    if not path.exists():
        raise UserError(path, "the video is missing", "get it, or leave its scene out")
    check_regular(path)
    try:
        with av.open(str(path)) as container:
            if not container.streams.video:
                raise UserError(path, "holds no video", "get the video again")
            stream = container.streams.video[0]
            stream.thread_type = "AUTO"
            origin = container.start_time or 0
            container.seek(start + origin)
            for frame in container.decode(stream):
                if frame.pts is not None and frame.time_base is not None:
                    yield round(frame.pts * Fraction(frame.time_base) * MICROSECONDS) - origin, frame
    except av.error.FFmpegError as error:
        told = " ".join(str(error).split())
        raise UserError(path, f"the video cannot be decoded ({told})", "get it again, as MP4 or WebM") from error


def _pixels(frame: Any) -> Pixels:  # noqa: ANN401 - PyAV's frame
    pixels: Pixels = np.ascontiguousarray(frame.to_ndarray(format="rgb24"))
    return pixels
