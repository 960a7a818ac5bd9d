"""What the hidden photographs say of the candidates: true PSNR and SSIM, and the gain of capturing one.

Oracles choose by it; ``avs.nvs.common_states`` sets the scores of other methods, which never see it, against it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from avs.representations.base import Renderer
from avs.representations.capabilities import Copyable
from avs.scene.views import Views
from avs.selection.batched_rendering import render_candidates
from avs.selection.contract import State, Truth
from metrics.image import psnr, ssim

FloatArray = npt.NDArray[np.float64]
ImageMetric = Literal["psnr", "ssim"]

_METRICS: dict[ImageMetric, Callable[[npt.NDArray[Any], npt.NDArray[Any]], float]] = {"psnr": psnr, "ssim": ssim}
# Candidates rendered at once, which bounds the memory.
_BATCH = 8


def hidden(state: State) -> Truth:
    """Return the photographs that only an oracle is shown.

    Raises:
        ValueError: the state has none; the method's metadata do not say ``oracle``.
    """
    if state.truth is None:
        raise ValueError("the hidden photographs are shown to methods with oracle=True only")
    return state.truth


def true_metrics(state: State, metrics: Sequence[ImageMetric]) -> FloatArray:
    """Compare the current rendering of every candidate with its hidden photograph; return ``[metrics, n]``."""
    photographs = hidden(state).candidates.images
    values = np.empty((len(metrics), len(photographs)))
    for rows, images in render_candidates(state, _BATCH):
        for row, image in zip(rows.tolist(), images, strict=True):
            values[:, row] = [_METRICS[metric](image, photographs[row]) for metric in metrics]
    return values


def gains(
    representation: Copyable,
    captured: Views,
    candidates: Views,
    test: Views,
    passes: int,
    metric: ImageMetric = "psnr",
    seed: int | None = None,
) -> FloatArray:
    """Return how much better the test images become by capturing each candidate instead of none.

    For each candidate a copy of the reconstruction is fitted on the captured views and the candidate, until it has used
    each of them ``passes`` times; one more copy is fitted without, for as many steps. All copies start from one state
    of the random generator. With equally many views they use them in one order, the candidate always at the same
    place, so that two candidates differ by their photographs and by nothing else.

    Args:
        representation: left as it is.
        captured: the views captured so far.
        candidates: ``n`` views with their photographs.
        test: the test views.
        passes: how often each view is used.
        metric: what to compare, as a mean over the test images.
        seed: of the random choices of the fits, the order of views above all; None goes on with the representation's.

    Returns:
        ``[n]`` differences of the metric, in decibels for PSNR.
    """
    steps = passes * (len(captured) + 1)

    def quality(views: Views) -> float:
        fitted = representation.copy(seed)
        fitted.fit(views, steps)
        return _mean_metric(fitted, test, metric)

    without = quality(captured)
    return np.array([quality(captured.extended(candidates[[row]])) - without for row in range(len(candidates))])


def sample(rng: np.random.Generator, candidates: int, size: int) -> npt.NDArray[np.int64]:
    """Return ``size`` rows of the candidates, or all if there are fewer, ascending."""
    return np.sort(rng.choice(candidates, min(candidates, size), replace=False))


def _mean_metric(renderer: Renderer, views: Views, metric: ImageMetric) -> float:
    values = np.empty(len(views))
    for _, rows in views.cameras.by_size():
        images = renderer.render(views.cameras[rows]).rgb
        values[rows] = [_METRICS[metric](image, views.images[row]) for row, image in zip(rows, images, strict=True)]
    return float(values.mean())
