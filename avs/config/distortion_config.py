"""The section of the configuration that names the data which scorers are trained on."""

from __future__ import annotations

from typing import Any, Self

from pydantic import Field, model_validator

from avs.iqa.cross_reference.scorer_settings import RenderSettings
from avs.system.models import StrictModel


class DistortionConfig(StrictModel):
    """The data sets that are not evaluated: all cross-reference scorers of the run are trained and measured on them."""

    training: tuple[str, ...] = Field(min_length=1, description="data sets whose scenes train scorers")
    held_out: tuple[str, ...] = Field(min_length=1, description="data sets whose scenes only measure scorers")
    representations: dict[str, dict[str, Any]] = Field(
        default_factory=dict,
        description="settings of the reconstruction of some of these data sets, by the data set's name: laid over the "
        "run's where kind is the same, else over the defaults of kind; the others have the run's own, and what stands "
        "here of a data set that no scorer uses counts for nothing",
    )
    renders: RenderSettings = Field(default_factory=RenderSettings, description="when a scene is rendered")

    @property
    def datasets(self) -> tuple[str, ...]:
        """The names of all of them."""
        return (*self.training, *self.held_out)

    @model_validator(mode="after")
    def _disjoint(self) -> Self:
        if len(set(self.datasets)) < len(self.datasets):
            raise ValueError("a data set is named twice; it either trains scorers or is held out")
        return self
