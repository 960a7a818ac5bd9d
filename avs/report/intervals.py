"""The interval that is printed beside a difference of two methods: over what it is taken, and what it covers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy.typing as npt

from metrics.statistics import Interval, interval_over_scenes, interval_over_seeds

CONFIDENCE = 0.95
"""Probability content of all intervals."""

Over = Literal["scenes", "seeds"]
"""What an interval generalises to: other scenes of this kind with any seeds, or other seeds of the same scenes."""

OVER: tuple[Over, ...] = ("scenes", "seeds")

# With two scenes Student's t has one degree of freedom: the interval is 13 times as wide as the scenes are apart.
_ENOUGH_SCENES = 3


def interval(differences: Sequence[npt.ArrayLike], over: Over) -> Interval | None:
    """Return the interval of paired differences, one sequence of seeds for each scene, or None if there is none."""
    function = interval_over_scenes if over == "scenes" else interval_over_seeds
    return function(differences, confidence=CONFIDENCE)


def printed_over(scenes: int, seeds: int) -> Over | None:
    """Return over what printed intervals are: scenes if there are three or more, else seeds; None for one of each.

    Two scenes with one seed leave an interval over scenes alone, with one degree of freedom.
    """
    if scenes < _ENOUGH_SCENES and seeds > 1:
        return "seeds"
    return "scenes" if scenes > 1 else None


def covers(over: Over | None, scenes: int) -> str:
    """Return what the printed intervals are and what they cover, as the end of a sentence."""
    if over is None:
        return "one scene with one seed has no interval"
    level = f"{CONFIDENCE:.0%} interval over {over}"
    if over == "scenes":
        wide = ", very wide with two of them" if scenes < _ENOUGH_SCENES else ""
        return f"{level} (other scenes of this kind with any seeds{wide})"
    these = "this scene" if scenes == 1 else f"these {scenes} scenes"
    return f"{level} (other seeds on {these}; not other scenes)"
