"""The record of how well everything predicts the SSIM of the renderings of one held-out scene; deterministic."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from avs.iqa.held_out.held_out_settings import HeldOutJob
from avs.system.models import StrictModel

Kind = Literal["network", "references", "metric", "regression", "plain"]
"""A network as its method uses it, the same with other references, a no-reference metric, a regression on render
statistics, or a number that needs no model."""


class Scored(StrictModel):
    """What one predictor says of each rendering."""

    identifier: str = Field(description="unique in the record, such as niqe")
    label: str = Field(description="printed name, such as NIQE")
    kind: Kind = Field(description="kind of predictor")
    worst: Literal["lowest", "highest"] = Field(description="which scores it gives to the renderings it takes for bad")
    scores: list[float] | None = Field(description="one for each rendering, or null with a reason in failure")
    pixel_error: float | None = Field(
        default=None, description="mean absolute error of predicted maps over all pixels; null where it predicts none"
    )
    pixel_pearson: float | None = Field(
        default=None, description="Pearson's correlation of predicted and true maps over all pixels, likewise"
    )
    weights_hash: str | None = Field(default=None, description="SHA-256 of its weights, or null")
    notes: list[str] = Field(default_factory=list, description="what a reader of its scores should know")
    failure: str | None = Field(default=None, description="why there are no scores, or null")


class HeldOutScores(StrictModel):
    """``held_out/<data set>/<scene>.json``."""

    schema_version: Literal[1] = 1
    dataset: str = Field(description="name of the held-out data set")
    scene: str
    scene_hash: str = Field(description="content hash of the scene")
    other_scene: str = Field(description="the scene whose photographs are the references of another scene")
    settings: HeldOutJob = Field(description="what was measured")
    moment: list[int] = Field(description="for each rendering the number of its moment")
    candidate: list[bool] = Field(description="for each, whether its view had not been captured at its moment")
    ssim: list[float] = Field(description="for each, the true SSIM of the image")
    scored: list[Scored] = Field(description="the predictors, in the order of the table's rows")
