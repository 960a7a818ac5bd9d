"""Rendering of many cameras in batches, which bounds the memory."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from avs.representations.base import FloatImages, Renderer, Rendering
from avs.scene.cameras import Cameras
from avs.selection.contract import State


def render_in_batches(
    renderer: Renderer, cameras: Cameras, batch: int
) -> Iterator[tuple[npt.NDArray[np.int64], Rendering]]:
    """Render all ``cameras``, at most ``batch`` of one image size at once.

    Yields:
        The rows of the cameras, and their renderings.
    """
    for _, indices in cameras.by_size():
        for rows in np.split(indices, range(batch, len(indices), batch)):
            yield rows, renderer.render(cameras[rows])


def render_candidates(state: State, batch: int) -> Iterator[tuple[npt.NDArray[np.int64], FloatImages]]:
    """Render all candidates, at most ``batch`` of one image size at once.

    Yields:
        The rows of the candidates, and their renderings ``[rows, height, width, 3]`` in 0..1.
    """
    for rows, rendering in render_in_batches(state.representation, state.candidates, batch):
        yield rows, rendering.rgb
