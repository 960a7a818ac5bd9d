"""At which states of a reconstruction all methods score the same candidates, and how well the truth is measured there.

Imports no torch, so that the workflow can read it quickly.
"""

from __future__ import annotations

import itertools
from typing import Any, Literal

from pydantic import Field, PositiveInt, field_validator

from avs.nvs.protocol import ProtocolSettings
from avs.representations.kinds import AnyRepresentationSettings
from avs.system.models import StrictModel


class CommonStatesSettings(StrictModel):
    """States that no method's choices led to, and what the hidden photographs say of their candidates."""

    order: Literal["random", "farthest"] = Field(
        default="random",
        description="order in which views are captured after the initial ones. random: drawn anew for each scene and "
        "seed, which favours no method and leaves near and far candidates; farthest: by farthest-view sampling, whose "
        "own states these are, with the same views for every seed",
    )
    views: tuple[PositiveInt, ...] = Field(
        default=(6, 12, 18),
        min_length=1,
        description="numbers of captured views at which candidates are scored; one that the budget or the steps of the "
        "schedule leave out becomes the nearest selection of an episode",
    )
    gain_candidates: PositiveInt | None = Field(
        default=16, description="size of the random sample of candidates whose gain is measured; null for all"
    )
    gain_passes: PositiveInt = Field(
        default=8, description="how often the fit that measures a gain uses each view, the candidate included"
    )

    @field_validator("views")
    @classmethod
    def _ascending(cls, views: tuple[int, ...]) -> tuple[int, ...]:
        if any(later <= earlier for earlier, later in itertools.pairwise(views)):
            raise ValueError("views must ascend")
        return views


class ScoredMethodSettings(StrictModel):
    """One method that scores the candidates."""

    method: str = Field(description="identifier")
    selector: dict[str, Any] = Field(description="its settings")
    views_together: PositiveInt = Field(default=1, description="views that it chooses together in an episode")


class CommonStatesJob(StrictModel):
    """What the job of a scene and a seed reads of the configuration."""

    device: Literal["cpu", "cuda"] = Field(description="where the reconstruction and networks run")
    protocol: ProtocolSettings = Field(description="the loop whose schedule the reconstruction follows")
    representation: AnyRepresentationSettings = Field(description="the reconstruction")
    common_states: CommonStatesSettings = Field(description="the states and their truth")
    methods: tuple[ScoredMethodSettings, ...] = Field(description="the methods that score, in order")
