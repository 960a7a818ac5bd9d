"""Compiles the CPU kernels ahead of their first use, so that no episode's times include it."""

from __future__ import annotations

import numpy as np

from avs.representations.gaussians.gaussian_settings import GaussianSettings
from avs.representations.gaussians.initialization import PointCloud
from avs.representations.gaussians.splats import GaussianSplats
from avs.representations.learned_variance import VarianceLearning, VarianceReduction
from avs.scene.cameras import Cameras
from avs.scene.views import Views


def compile_kernels() -> None:
    """Fit, render and differentiate a handful of Gaussians once; numba keeps what it compiles on disk."""
    generator = np.random.default_rng(0)
    positions = generator.normal(size=(16, 3)) + np.array([0.0, 0.0, 5.0])
    cloud = PointCloud(positions, np.full((16, 3), 0.5))
    cameras = Cameras(
        np.eye(4)[None], np.array([[[32.0, 0.0, 16.0], [0.0, 32.0, 16.0], [0.0, 0.0, 1.0]]]), np.array([[32, 32]])
    )
    views = Views(cameras, (np.full((32, 32, 3), 128, dtype=np.uint8),), ("grey.png",))
    splats = GaussianSplats(cloud, 1.0, GaussianSettings(), generator, "cpu")
    splats.fit(views, 2)
    splats.render(cameras)
    next(splats.fisher_diagonal(cameras, "once", ("means",)))
    splats.front_weights(cameras, np.ones((32, 32), dtype=np.float32), 0.8)
    splats.blended_values(cameras, np.ones(16, dtype=np.float32))
    splats = GaussianSplats(cloud, 1.0, GaussianSettings(), generator, "cpu")
    splats.learn_variance(VarianceLearning(learning_rate=None, constant=0.0, floor=0.1, attenuated=False))
    splats.fit(views, 2)
    splats.variance_reduction(cameras, VarianceReduction(constant=1e-4, weighted=True, saturated=False))
