"""Settings of the exploration. The defaults are those of FisherRF's mapping (its commit 8b196cd)."""

from __future__ import annotations

from typing import Self

from pydantic import Field, NonNegativeFloat, NonNegativeInt, PositiveFloat, PositiveInt, model_validator

from avs.system.models import StrictModel


class OccupancySettings(StrictModel):
    """The grid of what is known of the floor, seen from above, with the start in its middle."""

    cell: PositiveFloat = Field(default=0.05, description="edge of a cell in metres")
    cells: PositiveInt = Field(default=768, description="along each side of the grid")
    reach: PositiveFloat = Field(default=7.0, description="depths beyond this are not used, metres")
    low: float = Field(default=0.1, description="what lies lower above the floor is no obstacle, metres")
    high: float = Field(default=1.3, description="what lies higher is none, metres")
    gaussians: PositiveInt | None = Field(
        default=25, description="cells with more Gaussians than this between these heights are not free; null: no limit"
    )

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.low >= self.high:
            raise ValueError("low must be less than high, or nothing is an obstacle")
        return self


class FrontierSettings(StrictModel):
    """Frontiers, and the poses from which they are looked at."""

    least: PositiveInt = Field(default=11, description="cells of the smallest frontier that counts")
    far: NonNegativeFloat = Field(
        default=20.0, description="frontiers are ranked by size / (mean distance + this), both in cells"
    )
    considered: PositiveInt = Field(
        default=1,
        description="so many of the best get candidates; as released 1, so that all methods go to the same one",
    )
    candidates: PositiveInt = Field(default=256, description="poses that are drawn around the frontiers in all")
    nearest: PositiveFloat = Field(default=0.5, description="inner radius of the annulus around the centroid, metres")
    farthest: PositiveFloat = Field(default=1.0, description="its outer radius, metres")
    expansion: float = Field(default=1.5, gt=1, description="the annulus grows by this where no pose in it is free")
    expansions: NonNegativeInt = Field(default=4, description="how often it grows")
    erosion: PositiveInt = Field(
        default=10, description="free space is eroded by a square of so many cells; by half of it where no way is left"
    )
    patience: PositiveInt | None = Field(
        default=None,
        description="frontiers that so many decisions have gone to and that are still there no longer count; null: "
        "they always do, as released",
    )


class PathSettings(StrictModel):
    """Paths to candidates."""

    shortlist: PositiveInt = Field(default=20, description="candidates to which paths are planned")
    horizon: PositiveInt = Field(
        default=30, description="a path ends after so many actions, and a new decision is made there"
    )
    clearance: NonNegativeFloat = Field(
        default=0.3, description="cells nearer to an obstacle than this cost more, metres"
    )
    clearance_cost: NonNegativeFloat = Field(default=3.0, description="what a cell at an obstacle costs more, in cells")


class ExplorationSettings(StrictModel):
    """A run of exploration."""

    steps: PositiveInt = Field(default=2000, description="actions of the robot")
    turns: NonNegativeInt = Field(default=72, description="turns to the left at the start")
    occupancy: OccupancySettings = Field(default=OccupancySettings(), description="what is known of the floor")
    frontiers: FrontierSettings = Field(default=FrontierSettings(), description="frontiers and candidate poses")
    paths: PathSettings = Field(default=PathSettings(), description="paths to the candidates")

    @model_validator(mode="after")
    def _something_is_chosen(self) -> Self:
        if self.turns >= self.steps:
            fault = f"the {self.turns} turns at the start take all {self.steps} actions, so that no path is ever chosen"
            raise ValueError(f"{fault}; raise steps, or lower turns")
        return self
