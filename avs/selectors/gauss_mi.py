"""GauSS-MI: the candidate that shows the least reliable Gaussians (RSS 2025, arXiv 2504.21067)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from pydantic import Field, PositiveFloat

from avs.representations.base import Renderer
from avs.representations.capabilities import HasBlendingWeights, capability
from avs.scene.cameras import Cameras, concatenate
from avs.scene.views import Views
from avs.selection.batched_rendering import render_in_batches
from avs.selection.contract import Method, Resources, Settings, State

Floats = npt.NDArray[np.float64]


class GaussMiSettings(Settings):
    """Settings of GauSS-MI; the defaults are those of its code."""

    loss_scale: PositiveFloat = Field(
        default=1.7, description="lambda_L: a pixel whose mean absolute error is its inverse says nothing"
    )
    weight_scale: PositiveFloat = Field(default=10.0, description="lambda_T: log-odds per blending weight")
    least_loss: float = Field(default=1e-4, gt=0, description="lower bound of the scaled losses")
    least_transmittance: float = Field(
        default=0.8, ge=0, lt=1, description="a Gaussian is judged by pixels that more light than this reaches"
    )
    least_pixels: int = Field(default=5, ge=0, description="and only if there are this many of them")


class GaussMiSelector:
    """Largest rendered sum of the Gaussians' information gain, -log of their reliability."""

    def __init__(self, settings: GaussMiSettings, resources: Resources) -> None:
        """Keep the settings; no resources are needed."""
        self._settings = settings

    def score(self, state: State) -> Floats:
        """Return the sum for each candidate, ``[n]``.

        Raises:
            UserError: the representation does not blend primitives.
        """
        blending = capability(state.representation, HasBlendingWeights, "gauss-mi")
        axes = horizontal_axes(concatenate([state.captured.cameras, state.candidates]))
        gains = -np.log(reliability(state.representation, blending, state.captured, axes, self._settings))
        scores = np.empty(len(state.candidates))
        for row in range(len(scores)):
            camera = state.candidates[row]
            seen = (gains * direction_weights(blending.centres, camera, axes)).sum(axis=1)
            scores[row] = blending.blended_values(camera, seen.astype(np.float32)).sum(dtype=np.float64)
        return scores


def reliability(
    renderer: Renderer, blending: HasBlendingWeights, captured: Views, axes: Floats, settings: GaussMiSettings
) -> Floats:
    """Return each primitive's probability of being reliable, seen along each of four directions: ``[primitives, 4]``.

    A Bayes filter in log-odds, from 0.5 on: each captured view adds lambda_T times the sum of a primitive's blending
    weights times -log(lambda_L loss), spread over the directions by ``direction_weights``. Steps are held in -10..10
    and probabilities in 1e-4..0.9999.
    """
    losses: dict[int, npt.NDArray[np.float32]] = {}
    for rows, rendering in render_in_batches(renderer, captured.cameras, 8):
        for row, rgb in zip(rows.tolist(), rendering.rgb, strict=True):
            losses[row] = np.abs(rgb - captured.images[row] / np.float32(255)).mean(axis=2)
    log_odds = np.zeros((len(blending.centres), 4))
    bound = np.log(0.9999 / 0.0001)
    for row in range(len(captured)):
        camera = captured.cameras[row]
        evidence = -np.log(np.maximum(settings.loss_scale * losses[row], settings.least_loss))
        sums, pixels = blending.front_weights(camera, evidence, settings.least_transmittance)
        step = settings.weight_scale * sums[:, None] * direction_weights(blending.centres, camera, axes)
        step[pixels < settings.least_pixels] = 0
        log_odds = np.clip(log_odds + np.clip(step, -10, 10), -bound, bound)
    return np.asarray(1 / (1 + np.exp(-log_odds)))


def direction_weights(centres: npt.NDArray[np.float32], camera: Cameras, axes: Floats) -> Floats:
    """Return the cosines of the viewing directions with both axes, then with their opposites, 0 where negative.

    Args:
        centres: ``[primitives, 3]``.
        camera: one camera.
        axes: ``[2, 3]`` unit vectors.

    Returns:
        ``[primitives, 4]``.
    """
    rays = centres - camera.centers
    cosines = rays @ axes.T / np.maximum(np.linalg.norm(rays, axis=1, keepdims=True), np.finfo(np.float64).tiny)
    return np.asarray(np.maximum(np.concatenate([cosines, -cosines], axis=1), 0))


def horizontal_axes(cameras: Cameras) -> Floats:
    """Return two orthogonal unit vectors ``[2, 3]`` across the mean upright of the cameras: x and y if that is z."""
    up = -cameras.world_to_camera[:, 1, :3].mean(axis=0)
    length = np.linalg.norm(up)
    up = up / length if length > 1e-6 else np.array([0.0, 0.0, 1.0])
    first = np.eye(3)[0 if abs(up[0]) < 0.9 else 1]
    first = first - up * (up @ first)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(up, first)])


METHODS = {
    "gauss-mi": Method(
        label="GauSS-MI",
        group="3D-based",
        source=(
            "Xie et al., RSS 2025 (arXiv 2504.21067), and its code at commit 61f5158. Deviations: reliabilities are "
            "computed again from all captured views, as densification changes the Gaussians; the loss has no depth "
            "part, as there is no depth sensor, and no image mask; the four directions lie across the cameras' mean "
            "upright instead of across z; the robot's cost of motion is left out."
        ),
        chooses="highest",
        build=GaussMiSelector,
        settings=GaussMiSettings,
        needs=("blending_weights",),
    )
}
