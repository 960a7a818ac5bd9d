"""Compiles the kernels of dense stereo ahead of their first use, so that no two jobs do it at once."""

from __future__ import annotations

import numpy as np

from avs.scene.cameras import Cameras
from avs.sfm.depth_maps import Stereo, depth_map, picture_of, refined
from avs.sfm.sfm_settings import StereoSettings
from avs.sfm.stereo_vectors import bordered

_WIDTH, _HEIGHT = 32, 24


def compile_stereo() -> None:
    """Compare two small pictures once; numba keeps what it compiles on disk."""
    generator = np.random.default_rng(0)
    pictures = [picture_of(generator.integers(0, 256, (_HEIGHT, _WIDTH), dtype=np.uint8)) for _ in range(2)]
    matrix = np.array([[_WIDTH, 0, _WIDTH / 2], [0, _WIDTH, _HEIGHT / 2], [0, 0, 1]])
    transforms = np.stack([np.eye(4)] * 2)
    transforms[1, 0, 3] = -0.1
    cameras = Cameras(transforms, np.stack([matrix] * 2), np.array([[_WIDTH, _HEIGHT]] * 2, dtype=np.int64))
    stereo = Stereo(pictures, pictures, cameras, (0.5, 2.0))
    settings = StereoSettings(planes=16)
    found = depth_map(stereo, settings, seed=0)
    refined(stereo, found.planes, 0.1, 1, settings.active, 0, [bordered(found.planes[..., 0])])
