"""What is measured of the coverage of views, and how."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, PositiveFloat

from avs.sfm.back_end_registry import AnyBackEndSettings, create_settings
from avs.system.models import Different, StrictModel
from metrics.coverage import ExtentDefinition

Device = Literal["cpu", "cuda"]


class CoverageSettings(StrictModel):
    """The coverage of the scene by the views of each episode, and its table and figures."""

    sfm: AnyBackEndSettings = Field(
        default_factory=lambda: create_settings({}), description="the back end of structure from motion"
    )
    reference_views: Literal["all", "pool"] = Field(
        default="all", description="views of the reference cloud: all of the scene, or those that methods choose from"
    )
    extent: ExtentDefinition = Field(
        default="robust_box",
        description="what the extent of the reference cloud is, of which thresholds are shares: the diagonal of the "
        "box along its principal axes that holds the middle 98 % of its points along each, or of that along the "
        "coordinate axes that holds all",
    )
    threshold: PositiveFloat = Field(default=0.01, description="of the SCR, in extents")
    thresholds: Annotated[tuple[PositiveFloat, ...], Different] = Field(
        default=(0.001, 0.01, 0.1), min_length=1, description="over which the F-score is a mean, in extents"
    )
    voxel: PositiveFloat = Field(
        default=0.005, description="edge of the voxels of which each counts once, in extents: half of the threshold"
    )
    views: Annotated[tuple[Annotated[int, Field(ge=2)], ...], Different] = Field(
        default=(4, 8, 12, 16),
        description="numbers of views, in the order of capture, at which the SCR is measured besides the end; a cloud "
        "is made for each",
    )
    scene: str | None = Field(
        default=None,
        description="scene of the figure of maps, by its name or as dataset/scene; null for the first of the first "
        "data set",
    )


class ReferenceJob(StrictModel):
    """What the reference of a scene reads."""

    device: Device = Field(description="where networks run")
    sfm: AnyBackEndSettings = Field(description="the back end of structure from motion")
    reference_views: Literal["all", "pool"] = Field(description="views of the cloud")
    extent: ExtentDefinition = Field(description="what the extent is")
    voxel: PositiveFloat = Field(description="edge of the voxels of which each counts once, in extents")


class CoverageJob(StrictModel):
    """What the coverage of an episode reads."""

    device: Device = Field(description="where networks run")
    sfm: AnyBackEndSettings = Field(description="the back end of structure from motion")
    threshold: PositiveFloat = Field(description="of the SCR, in extents")
    thresholds: tuple[PositiveFloat, ...] = Field(description="over which the F-score is a mean, in extents")
    voxel: PositiveFloat = Field(description="edge of the voxels of which each counts once, in extents")
    views: tuple[int, ...] = Field(description="numbers of views at which the SCR is measured besides the end")
