"""Settings of 3D Gaussian splatting; the defaults are those of Kerbl et al. 2023 (arXiv 2308.04079)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from avs.representations.base import RepresentationSettings
from avs.representations.needed_points import NeededPoints
from avs.system.models import Color, StrictModel

Points = Literal["random", "sfm", "selected"]
ExtentChoice = Literal["robust", "all_cameras"]

CAMERAS_PER_BATCH = 8
"""Cameras that one call of the rasteriser renders, which bounds its memory."""

LEAST_POINTS = 4
"""A Gaussian's first scale takes the distances to three other points."""


class InitialPoints(StrictModel):
    """Where the Gaussians start."""

    choice: Points = Field(
        default="random",
        description="random: uniform in a cube around the cameras; sfm: every point of structure from motion, also "
        "those that only test or candidate images see; selected: the points that captured images see",
    )
    random_count: int = Field(
        default=100_000, ge=4, description="number of random points, as in gsplat's simple_trainer"
    )
    random_bounds: float = Field(
        default=3.0,
        gt=0,
        description="half the side of the random cube in units of the scene extent; its middle is the mean centre of "
        "the cameras that the extent is of, as in gsplat's simple_trainer",
    )
    selected_min_views: int = Field(
        default=1, ge=1, description="number of captured images that must see a point for choice 'selected'"
    )
    max_count: int | None = Field(
        default=None,
        ge=4,
        description="at most this many points of structure from motion, drawn at random; null is no limit",
    )
    opacity: float = Field(default=0.1, gt=0, lt=1, description="opacity of every Gaussian at the start")


class LearningRates(StrictModel):
    """Adam's learning rates; each parameter group has its own."""

    means: float = Field(default=1.6e-4, gt=0, description="positions at the start, in units of the scene extent")
    means_final: float = Field(default=1.6e-6, gt=0, description="positions at the end; exponential in between")
    f_dc: float = Field(default=2.5e-3, gt=0, description="spherical harmonics of degree 0")
    f_rest: float = Field(default=2.5e-3 / 20, gt=0, description="spherical harmonics of degree 1 and above")
    opacities: float = Field(default=0.05, gt=0, description="logit of the opacity")
    scales: float = Field(default=5e-3, gt=0, description="logarithm of the scale")
    quats: float = Field(default=1e-3, gt=0, description="quaternion of the rotation")


class Densification(StrictModel):
    """Adaptive density control: cloning, splitting and pruning of Gaussians. Counts are optimisation steps from 1."""

    start: int = Field(default=500, ge=0, description="no change up to and including this step")
    every: int = Field(default=100, ge=1, description="steps between changes")
    until: int = Field(default=15_000, ge=0, description="no change and no opacity reset from this step on")
    gradient_threshold: float = Field(
        default=2e-4,
        gt=0,
        description="a Gaussian grows where the mean norm of its image plane gradient, in normalised device "
        "coordinates, exceeds this",
    )
    absolute_gradient: bool = Field(
        default=False,
        description="sum absolute gradients over pixels (AbsGS, arXiv 2404.10484), which needs a higher threshold",
    )
    split_scale: float = Field(
        default=0.01,
        gt=0,
        description="a growing Gaussian is split above this scale and cloned below, in units of the scene extent",
    )
    prune_opacity: float = Field(default=0.005, ge=0, lt=1, description="Gaussians below this opacity are removed")
    prune_scale: float = Field(
        default=0.1,
        gt=0,
        description="Gaussians above this scale, in units of the scene extent, are removed once the first opacity "
        "reset is past",
    )
    opacity_reset_every: int = Field(default=3000, ge=1, description="steps between opacity resets")
    opacity_reset_value: float = Field(default=0.01, gt=0, lt=1, description="highest opacity after a reset")
    max_gaussians: int | None = Field(
        default=None,
        ge=4,
        description="budget: where growth would exceed it, only the Gaussians of the largest gradients grow; null is "
        "no limit, as in the paper",
    )


class GaussianSettings(RepresentationSettings):
    """3D Gaussian splatting. The defaults are the paper's; a scale of the benchmark replaces numbers only."""

    kind: Literal["gaussians"] = Field(default="gaussians", description="3D Gaussian splatting")
    iterations: int = Field(
        default=30_000, ge=1, description="length of the schedule of the positions' learning rate, in steps"
    )
    extent: ExtentChoice = Field(
        default="robust",
        description="robust: the scene extent leaves stray cameras out; all_cameras: that of 3DGS, which one wrong "
        "pose changes. Without stray cameras they are the same",
    )
    sh_degree: int = Field(default=3, ge=0, le=3, description="highest degree of the spherical harmonics")
    sh_increase_every: int = Field(
        default=1000, ge=1, description="steps between increases of the degree, which starts at 0"
    )
    ssim_weight: float = Field(default=0.2, ge=0, le=1, description="weight of D-SSIM in the loss; L1 has the rest")
    background: Color = Field(default=(0.0, 0.0, 0.0), description="colour behind the Gaussians, in 0..1")
    adam_epsilon: float = Field(default=1e-15, gt=0, description="Adam's epsilon")
    points: InitialPoints = Field(default=InitialPoints(), description="where the Gaussians start")
    learning_rates: LearningRates = Field(default=LearningRates(), description="Adam's learning rates")
    densification: Densification = Field(default=Densification(), description="adaptive density control")

    def needed_points(self) -> NeededPoints | None:
        """Return what ``points.choice`` needs: as many points as one has neighbours, and itself."""
        if self.points.choice == "random":
            return None
        selected = self.points.choice == "selected"
        return NeededPoints(
            count=LEAST_POINTS,
            views=self.points.selected_min_views if selected else 0,
            setting=f"representation.points.choice '{self.points.choice}'",
            otherwise="representation: {points: {choice: sfm}}",
            without="representation: {points: {choice: random}}",
        )
