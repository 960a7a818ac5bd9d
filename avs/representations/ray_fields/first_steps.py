"""A field's first steps on one grey photograph, by which its kernels are compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from avs.representations.base import Representation, RepresentationSettings
from avs.scene.cameras import Cameras
from avs.scene.similarity import IDENTITY, Similarity
from avs.scene.views import Views

Settings = TypeVar("Settings", bound=RepresentationSettings)


def fit_and_render(
    build: Callable[[Settings, float, Similarity, int, str], Representation], settings: Settings
) -> None:
    """Fit what ``build`` makes of settings, radius, map to the capture, seed and device, for two steps; render it."""
    lens = np.array([[[32.0, 0.0, 8.0], [0.0, 32.0, 8.0], [0.0, 0.0, 1.0]]])
    cameras = Cameras(np.eye(4)[None], lens, np.array([[16, 16]]))
    views = Views(cameras, (np.full((16, 16, 3), 128, dtype=np.uint8),), ("grey.png",))
    field = build(settings, 1.0, IDENTITY, 0, "cpu")
    field.fit(views, 2)
    field.render(cameras)
