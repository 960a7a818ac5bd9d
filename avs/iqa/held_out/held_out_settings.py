"""What is measured on held-out scenes. Imports no torch, so that the workflow can read it quickly."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, NonNegativeInt, PositiveInt

from avs.iqa.cross_reference.scorer_settings import Precision, ReferenceSettings
from avs.iqa.render_statistics.regression_settings import RegressionSettings
from avs.iqa.resizing import ResizeSettings
from avs.system.models import StrictModel

STATISTICS = "statistics"
"""The method whose weights are the regressions on render statistics."""


class ReferencesVariant(StrictModel):
    """Other photographs for a network to compare a rendering with than its method takes."""

    count: NonNegativeInt = Field(description="number of photographs; 0 gives it one black image")
    choice: Literal["random", "nearest", "wrong"] = Field(
        default="random",
        description="of those captured at the moment, drawn for each rendering or nearest to its camera; or drawn from "
        "all photographs of another held-out scene",
    )


def _variants() -> dict[str, ReferencesVariant]:
    numbers = {f"{count} of the captured": ReferencesVariant(count=count) for count in (0, 1, 3, 5)}
    nearest = ReferencesVariant(count=5, choice="nearest")
    return numbers | {"5 nearest": nearest, "5 of another scene": ReferencesVariant(count=5, choice="wrong")}


class ScorerEvaluationSettings(StrictModel):
    """The table of how well scorers predict SSIM on held-out scenes."""

    references: dict[str, ReferencesVariant] = Field(
        default_factory=_variants,
        description="what each network is compared with in further rows of the table, by what the rows are called",
    )
    batch: PositiveInt = Field(default=8, description="renderings scored at once; bounds the memory")


class ScoredNetwork(StrictModel):
    """A network that scores, as the method of that name uses it."""

    method: str = Field(description="identifier of the method")
    label: str = Field(description="printed name of the network, whatever the method does with its scores")
    backbone: str = Field(description="image encoder that its weights must have")
    references: ReferenceSettings = Field(description="what the method compares a rendering with")
    resize: ResizeSettings = Field(description="size of the images that the network sees")
    precision: Precision = Field(description="number format that it computes in")


class ScoredMetric(StrictModel):
    """A method that scores each image by itself."""

    method: str = Field(description="identifier")
    selector: dict[str, Any] = Field(description="its settings")


class HeldOutJob(StrictModel):
    """What the job of one held-out scene reads of the configuration."""

    device: Literal["cpu", "cuda"] = Field(description="where networks run")
    evaluation: ScorerEvaluationSettings = Field(description="what is measured")
    networks: tuple[ScoredNetwork, ...] = Field(description="the networks, in order")
    metrics: tuple[ScoredMetric, ...] = Field(description="the metrics, in order")
    statistics: RegressionSettings | None = Field(
        description="what the regressions on render statistics read; null if the run fits none"
    )
