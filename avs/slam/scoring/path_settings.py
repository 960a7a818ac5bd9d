"""What chooses a path, by name, with its settings; read without torch."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, PositiveFloat, PositiveInt

from avs.system.models import StrictModel


class FisherPathSettings(StrictModel):
    """FisherRF's constants; the defaults are those of its code."""

    kind: Literal["fisherrf"] = Field(default="fisherrf", description="FisherRF as its mapping was released")
    gradient: PositiveFloat = Field(
        default=1e-3, description="gradient of each pixel's channels; the information scales with its square"
    )
    endpoint_regularisation: PositiveFloat = Field(
        default=0.1, description="lambda of the endpoint's score, which the code does not take from its settings"
    )
    path_regularisation: PositiveFloat = Field(default=1e-6, description="lambda of the information along a path")
    endpoint_weight: float = Field(default=30.0, ge=0, description="of the endpoint's score in that of the path")
    endpoint: Literal["plain", "logarithm"] = Field(
        default="plain",
        description="plain: the endpoint's score is added as it is, as released; logarithm: its logarithm is, as "
        "that of the information along the path",
    )
    every: PositiveInt = Field(default=5, description="actions between the poses of a path that are looked at")
    frame: Literal["camera", "world"] = Field(
        default="camera", description="axes of the positions that the information is of; released: each camera's own"
    )
    keyframes: PositiveInt | None = Field(
        default=None,
        description="at most so many keyframes, evenly spread, make up what is known; null: all, as released",
    )


class SelectorPathSettings(StrictModel):
    """A method of Task A."""

    kind: Literal["selector"] = Field(default="selector", description="a method of avs.selectors")
    method: str = Field(min_length=1, description="its identifier, such as ours-repvit")
    settings: dict[str, Any] = Field(default={}, description="those of the method, as under selectors")
    views: Literal["endpoint", "path"] = Field(
        default="path", description="endpoint: the view at the candidate alone; path: some along the way, and it"
    )
    every: PositiveInt = Field(default=5, description="actions between the views along a path")
    aggregate: Literal["mean", "best", "worst", "sum"] = Field(
        default="mean", description="of the scores of a path's views, in the method's own direction"
    )
    keyframes: PositiveInt | None = Field(
        default=None, description="at most so many keyframes, evenly spread, are shown as captured views; null: all"
    )


class NearestSettings(StrictModel):
    """The nearest candidate."""

    kind: Literal["nearest"] = Field(default="nearest", description="the shortest path")


class RandomPathSettings(StrictModel):
    """A path by chance."""

    kind: Literal["random"] = Field(default="random", description="a path by chance")


class OracleSettings(StrictModel):
    """The greedy oracle."""

    kind: Literal["oracle"] = Field(default="oracle", description="most new surface by metre, by the true mesh")


PathScorerSettings = Annotated[
    NearestSettings | RandomPathSettings | OracleSettings | FisherPathSettings | SelectorPathSettings,
    Field(discriminator="kind"),
]
