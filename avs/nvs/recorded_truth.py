"""What the record tells of the hidden photographs at a selection, for the ranking table; no method sees it."""

from __future__ import annotations

import numpy as np

from avs.nvs.protocol import TruthSettings
from avs.nvs.record import StepTruth
from avs.representations.capabilities import Copyable, capability
from avs.selection.contract import State
from avs.selection.truth import gains, hidden, sample, true_metrics


def is_measured(settings: TruthSettings, step: int) -> bool:
    """Whether ``settings`` ask for anything at this selection."""
    return _due(settings.image_every, step) or _due(settings.gain_every, step)


def measure_truth(state: State, settings: TruthSettings, rng: np.random.Generator) -> StepTruth:
    """Measure what ``settings`` ask for at this selection.

    Args:
        state: with the hidden photographs, before the choice is captured.
        settings: what to measure, and at which steps.
        rng: draws the sample whose gain is measured.

    Raises:
        UserError: the gain is asked for, and the representation cannot be copied.
    """
    images, gain = _due(settings.image_every, state.step), _due(settings.gain_every, state.step)
    found = true_metrics(state, ("psnr", "ssim")).tolist() if images else (None, None)
    return StepTruth(psnr=found[0], ssim=found[1], gain=_sampled_gains(state, settings, rng) if gain else None)


def _sampled_gains(state: State, settings: TruthSettings, rng: np.random.Generator) -> list[float | None]:
    representation = capability(state.representation, Copyable, "protocol.truth.gain_every")
    truth = hidden(state)
    rows = sample(rng, len(truth.candidates), settings.gain_candidates)
    values = gains(representation, state.captured, truth.candidates[rows], truth.test, settings.gain_passes)
    gain_of = dict(zip(rows.tolist(), values.tolist(), strict=True))
    return [gain_of.get(row) for row in range(len(truth.candidates))]


def _due(every: int | None, step: int) -> bool:
    return every is not None and step % every == 0
