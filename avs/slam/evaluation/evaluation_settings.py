"""Settings of the evaluation of a map."""

from __future__ import annotations

from pydantic import Field, NonNegativeInt, PositiveFloat, PositiveInt

from avs.system.models import Share, StrictModel


class EvaluationSettings(StrictModel):
    """What is measured of a map."""

    threshold: PositiveFloat = Field(default=0.05, description="of the surface coverage ratio, metres")
    points: PositiveInt = Field(
        default=50_000, description="drawn on the surface, of which those that can be seen count"
    )
    spacing: PositiveFloat = Field(default=0.5, description="of the places from which they might be seen, metres")
    every: PositiveInt = Field(default=100, description="actions between points of the curve of coverage")
    poses: NonNegativeInt = Field(
        default=1000, description="poses by chance on the floor at which the rendering is compared"
    )
    normalised: bool = Field(
        default=False, description="whether rendered depth is divided by the opacity for the depth error"
    )
    opacity: Share = Field(default=0.5, description="where more is rendered, depth is fused into a cloud")
    fused_every: PositiveInt = Field(default=10, description="frames of the trajectory whose rendered depth is fused")
    voxel: PositiveFloat = Field(default=0.01, description="of the fused cloud, metres")
    seed: NonNegativeInt = Field(default=42, description="of points and poses, the same for all runs in a building")
