"""Oracles: methods that look at the photographs of views not captured yet. Upper references, not competitors."""

from __future__ import annotations

from functools import partial
from typing import Literal

import numpy as np
from pydantic import Field, PositiveInt

from avs.representations.capabilities import Copyable, capability
from avs.selection.contract import ORACLE, Method, Resources, Selection, Settings, State
from avs.selection.truth import FloatArray, ImageMetric, gains, hidden, sample, true_metrics


class ImageOracle:
    """The candidate whose current rendering is the worst, compared with its photograph."""

    def __init__(self, metric: ImageMetric, settings: Settings, resources: Resources) -> None:
        """Keep the metric; there is nothing to set."""
        self._metric: ImageMetric = metric

    def score(self, state: State) -> FloatArray:
        """Return the true metric of each candidate's rendering, ``[n]``."""
        return np.asarray(true_metrics(state, [self._metric])[0])


class GainSettings(Settings):
    """Settings of the oracle of the gain."""

    candidates: PositiveInt = Field(default=16, description="size of the random sample of candidates that are tried")
    passes: PositiveInt = Field(
        default=2, description="how often the fit that tries a candidate uses each view, the candidate included"
    )
    metric: Literal["psnr", "ssim"] = Field(
        default="psnr", description="metric whose mean over test images should rise"
    )


class GainOracle:
    """The candidate, of a random sample, that raises the test metric most when it is captured."""

    def __init__(self, settings: GainSettings, resources: Resources) -> None:
        """Keep the settings; no resources are needed."""
        self._settings = settings

    def select(self, state: State, k: int) -> Selection:
        """Choose greedily: each further candidate is tried together with those chosen before it.

        The score is the gain when nothing is chosen yet; candidates outside the sample have none.

        Raises:
            UserError: the representation cannot be copied.
        """
        representation = capability(state.representation, Copyable, "oracle-gain")
        truth, settings = hidden(state), self._settings
        rows = sample(state.rng, len(state.candidates), max(k, settings.candidates))
        scores, scored = np.zeros(len(state.candidates)), np.zeros(len(state.candidates), dtype=bool)
        captured = state.captured
        chosen: list[int] = []
        for _ in range(k):
            left = np.setdiff1d(rows, chosen)
            found = gains(
                representation, captured, truth.candidates[left], truth.test, settings.passes, settings.metric
            )
            if not chosen:
                scores[left], scored[left] = found, True
            chosen.append(int(left[np.argmax(found)]))
            captured = captured.extended(truth.candidates[chosen[-1:]])
        return Selection(np.array(chosen, dtype=np.int64), scores, scored=scored)


def _image_oracle(metric: ImageMetric, name: str) -> Method:
    return Method(
        label=f"Oracle ({name})",
        group=ORACLE,
        source=(
            f"The paper's hypothesis itself (section 3, Algorithm 1): the view of the lowest {name}, here the true one "
            "against the hidden photograph instead of a prediction."
        ),
        chooses="lowest",
        build=partial(ImageOracle, metric),
        oracle=True,
        measures=metric,
    )


METHODS = {
    "oracle-ssim": _image_oracle("ssim", "SSIM"),
    "oracle-psnr": _image_oracle("psnr", "PSNR"),
    "oracle-gain": Method(
        label="Oracle (gain)",
        group=ORACLE,
        source=(
            "Error reduction (Roy and McCallum 2001) measured, not estimated: a copy is fitted with each candidate of "
            "a random sample, and the one after which the test images are best is taken. Greedy over a short fit, not "
            "optimal over the whole episode."
        ),
        chooses="highest",
        build=GainOracle,
        settings=GainSettings,
        oracle=True,
        measures="gain",
        needs=("copy",),
    ),
}
