"""Settings of the mapper. The defaults are SplaTAM's for Replica (its commit da6bbcd)."""

from __future__ import annotations

from pydantic import Field, NonNegativeFloat, NonNegativeInt, PositiveFloat, PositiveInt

from avs.system.models import Share, StrictModel


class MapRates(StrictModel):
    """Adam's learning rates while the map is optimised."""

    means: PositiveFloat = Field(default=1e-4, description="positions, metres")
    rgb: PositiveFloat = Field(default=2.5e-3, description="colours")
    opacities: PositiveFloat = Field(default=0.05, description="logit of the opacity")
    scales: PositiveFloat = Field(default=1e-3, description="logarithm of the scale")


class GrowthSettings(StrictModel):
    """Where Gaussians are added."""

    silhouette: Share = Field(default=0.5, description="where less opacity than this is rendered, the map is empty")
    error_factor: PositiveFloat = Field(
        default=50.0,
        description="and where it lies behind what is seen, by an error of more than so many times the median error",
    )
    spacing: PositiveFloat | None = Field(
        default=None,
        description="and where no Gaussian's centre lies within this of what is seen, metres, so that what was first "
        "seen from afar becomes as dense as what is near; null: SplaTAM's rule alone",
    )
    stride: PositiveInt = Field(
        default=1, description="every so manieth row and column gets a Gaussian, that many times as large"
    )
    nearest: NonNegativeFloat = Field(default=0.0, description="depths up to this are not used, metres")
    opacity: float = Field(default=0.5, gt=0, lt=1, description="of a new Gaussian")
    max_gaussians: PositiveInt | None = Field(
        default=None,
        description="no more Gaussians than this; of new ones that would exceed it some are drawn by chance",
    )


class PruningSettings(StrictModel):
    """Which Gaussians are removed while the map is optimised."""

    iterations: tuple[NonNegativeInt, ...] = Field(default=(0, 20), description="at which, counted from 0")
    opacity: Share = Field(default=0.005, description="those of a lower opacity")
    scale: PositiveFloat = Field(
        default=0.1, description="those of a greater scale, in units of the scene's radius: a third of the first depth"
    )


class KeyframeSettings(StrictModel):
    """Which pictures the map is optimised on."""

    every: PositiveInt = Field(default=5, description="frames between keyframes")
    window: PositiveInt = Field(
        default=24,
        description="pictures of one optimisation: the current one, the last keyframe and others, drawn among those "
        "that see some of what the current one sees",
    )
    samples: PositiveInt = Field(default=1600, description="pixels of the current picture that overlap is judged by")
    border: float = Field(
        default=1 / 60,
        ge=0,
        lt=0.5,
        description="a margin of a keyframe where nothing counts as seen, as a share of its width (SplaTAM: 20 pixels "
        "of 1200)",
    )


class TrackingSettings(StrictModel):
    """How the pose of a picture is found."""

    iterations: PositiveInt = Field(default=40, description="of Adam, for each picture")
    rotation_rate: PositiveFloat = Field(default=4e-4, description="learning rate of the quaternion")
    translation_rate: PositiveFloat = Field(default=2e-3, description="learning rate of the translation, metres")
    silhouette: Share = Field(default=0.99, description="pixels count where more opacity than this is rendered")
    depth_weight: NonNegativeFloat = Field(default=1.0, description="of the sum of absolute errors of depth")
    color_weight: NonNegativeFloat = Field(default=0.5, description="of the sum of absolute errors of colour")
    again_above: PositiveFloat | None = Field(
        default=None,
        description="where the depth's part of the loss ends above this, as many iterations follow once more "
        "(SplaTAM for ScanNet++: 20000)",
    )


class MapperSettings(StrictModel):
    """SplaTAM's loop, with isotropic Gaussians whose colour is the same from all sides."""

    map_every: PositiveInt = Field(default=1, description="frames between optimisations of the map (FisherRF: 10)")
    iterations: PositiveInt = Field(default=60, description="of one optimisation of the map")
    depth_weight: NonNegativeFloat = Field(default=1.0, description="of the mean absolute error of depth")
    color_weight: NonNegativeFloat = Field(default=0.5, description="of the photometric loss")
    ssim_weight: Share = Field(default=0.2, description="of D-SSIM in the photometric loss; L1 has the rest")
    adam_epsilon: PositiveFloat = Field(
        default=1e-15,
        description="Adam's epsilon; with SplaTAM's, what is hardly seen moves as fast as what is seen well, and a map "
        "that is optimised for long forgets (docs/active-slam.md)",
    )
    rates: MapRates = Field(default=MapRates(), description="learning rates")
    growth: GrowthSettings = Field(default=GrowthSettings(), description="where Gaussians are added")
    pruning: PruningSettings = Field(default=PruningSettings(), description="which are removed")
    keyframes: KeyframeSettings = Field(default=KeyframeSettings(), description="what the map is optimised on")
    tracking: TrackingSettings | None = Field(default=None, description="null: poses are given, as FisherRF's are")


RELEASED_MAPPING = MapperSettings(
    map_every=10,
    rates=MapRates(means=1e-3, scales=1e-2),
    growth=GrowthSettings(error_factor=10.0, stride=4, nearest=0.01),
    pruning=PruningSettings(opacity=1e-4),
    keyframes=KeyframeSettings(every=4, window=32),
)
"""The constants of FisherRF's mapping (its commit 8b196cd), whose Gaussians are anisotropic where these are not."""
