"""What the page tells of the states at which all methods scored the same candidates, and of the truth about these."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from avs.nvs.common_states_record import CommonState, CommonStates
from avs.report.page.script_files import told_apart


def states_facts(record: CommonStates, names: Sequence[str]) -> dict[str, Any]:
    """Return the states of one scene and seed, with images as places in ``names``.

    Args:
        record: the common states.
        names: image names of the scene, ascending.
    """
    places = {name: place for place, name in enumerate(names)}
    return {
        "seed": record.seed,
        "captured": [places[name] for name in record.captured],
        "states": [_state(state, places) for state in record.states],
        "methods": [
            {
                "id": each.method,
                "label": each.label,
                "group": each.group,
                "chooses": each.chooses,
                "own_fit": each.own_fit,
                "failure": each.failure,
                "scores": [None if scores is None else told_apart(scores) for scores in each.scores],
            }
            for each in record.methods
        ],
    }


def _state(state: CommonState, places: dict[str, int]) -> dict[str, Any]:
    return {
        "views": state.views,
        "iteration": state.iteration,
        "candidates": [places[name] for name in state.candidates],
        "psnr": told_apart(state.psnr),
        "ssim": told_apart(state.ssim),
        "gain": None if state.gains is None else _gain(state.gains),
    }


def _gain(gains: Sequence[Sequence[float | None]]) -> list[float | None]:
    """Return the mean of both measurements of each candidate, as the table of ranking has it; None without both."""
    pairs = zip(*gains, strict=True)
    return told_apart(
        [None if None in pair else float(np.mean([value for value in pair if value is not None])) for pair in pairs]
    )
