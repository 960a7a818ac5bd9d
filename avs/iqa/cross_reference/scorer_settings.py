"""Settings of the cross-reference scorer. Imports no torch, so that the workflow can read them quickly."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, NonNegativeFloat, NonNegativeInt, PositiveFloat, PositiveInt, model_validator

from avs.iqa.resizing import ResizeSettings
from avs.representations.kinds import AnyRepresentationSettings
from avs.system.models import StrictModel

BACKBONE_OF = {
    "lite0": "tf_efficientnet_lite0",
    "repvit": "repvit_m0_9",
    "dinov2": "vit_small_patch14_dinov2",
}
"""The scorers that a run can train, and the image encoder that gives each its name."""

PUBLISHED = {"dinov2": "crossscore"}
"""Scorers that others have trained and published, by their names in the manifest of ``avs.system.weights``."""

Precision = Literal["float32", "bfloat16"]
"""Numbers that a scorer computes with."""

PATCH = 14
"""Pixels along a side of the square that one token describes, as in DINOv2 and CrossScore."""

ENCODED_AT_ONCE = 32
"""Images that a backbone which learns nothing sees at once, which bounds its memory."""

ReferenceChoice = Literal["random", "nearest"]


class ReferenceSettings(StrictModel):
    """Which captured photographs an image is compared with."""

    count: PositiveInt = Field(default=5, description="number of reference images for one query image")
    choice: ReferenceChoice = Field(
        default="random",
        description="drawn again for each query image, or those whose camera centres are nearest to its own",
    )
    pad: Literal["none", "black"] = Field(
        default="none",
        description="when photographs are too few: use those there are, or fill up with black images as CrossScore",
    )


class NetworkSettings(StrictModel):
    """Architecture behind the backbone. Everything that a checkpoint must agree with."""

    backbone: str = Field(description="image encoder")
    channels: PositiveInt = Field(default=256, description="width of a token")
    layers: PositiveInt = Field(default=2, description="decoder layers")
    heads: PositiveInt = Field(default=8, description="attention heads; divides `channels`")
    hidden: PositiveInt = Field(default=256, description="width of the decoder's feed-forward layers")
    position_size: int = Field(default=40, ge=2, description="side of the grid of random position codes")
    position_seed: NonNegativeInt = Field(default=0, description="seed of the position codes")
    standardized: bool = Field(
        default=False,
        description="bring each of the backbone's channels to mean 0 and deviation 1 over the training images, so that "
        "feature maps count alike beside the position codes",
    )

    @model_validator(mode="after")
    def _heads_divide(self) -> Self:
        if self.channels % self.heads:
            raise ValueError(f"heads ({self.heads}) must divide channels ({self.channels})")
        return self


class RepViTSettings(NetworkSettings):
    """The network of Ours-RepViT: four feature maps, each projected to the width of a token."""

    backbone: Literal["repvit_m0_9"] = Field(default="repvit_m0_9", description="image encoder")
    taps: Literal["A", "B"] = Field(
        default="A",
        description="RepViT's layers '2, 6, 22, 25': A counts the 26 blocks from 0 without the stem, B with the stem",
    )


class EfficientNetLite0Settings(NetworkSettings):
    """The network of Ours-EfficientNet-Lite0: the paper's, on a backbone as fast, whose weights come by pip."""

    backbone: Literal["tf_efficientnet_lite0"] = Field(default="tf_efficientnet_lite0", description="image encoder")
    standardized: bool = Field(
        default=True,
        description="bring each of the backbone's channels to mean 0 and deviation 1 over the training images; as they "
        "are, the deviations at the four taps are 8.6, 6.3, 4.6 and 1.8, beside 1 of the position codes",
    )


class DINOv2Settings(NetworkSettings):
    """The network of CrossScore and Ours-DINOv2: the backbone's own tokens, not projected."""

    backbone: Literal["vit_small_patch14_dinov2"] = Field(
        default="vit_small_patch14_dinov2", description="image encoder"
    )
    channels: Literal[384] = Field(default=384, description="width of a token, the backbone's")
    hidden: PositiveInt = Field(default=384, description="width of the decoder's feed-forward layers")


AnyNetwork = Annotated[RepViTSettings | EfficientNetLite0Settings | DINOv2Settings, Field(discriminator="backbone")]


class RenderSettings(StrictModel):
    """Distortion data: when a training scene is rendered while it is being reconstructed.

    A run begins with farthest-view sampling, like an episode, and adds views at random between the moments; so the
    artefacts are those that a selector meets. CrossScore renders at 1000, 7000 and 15000 steps of one run on all views.
    """

    views: tuple[Annotated[int, Field(ge=2)], ...] = Field(
        default=(4, 6, 8, 12, 16, 20), min_length=1, description="number of captured views at each moment, ascending"
    )
    iterations: tuple[PositiveInt, ...] = Field(
        default=(400, 1500, 3000, 7200, 13000, 20000), min_length=1, description="optimisation steps at each moment"
    )
    runs: PositiveInt = Field(default=1, description="reconstructions of the scene, with different views")
    cameras: PositiveInt = Field(default=64, description="most images to render at one moment, sampled from all views")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if len(self.views) != len(self.iterations):
            raise ValueError(f"views has {len(self.views)} entries, iterations {len(self.iterations)}")
        if any(later < earlier for earlier, later in pairwise(self.views)):
            raise ValueError("views must not descend")
        if any(later <= earlier for earlier, later in pairwise(self.iterations)):
            raise ValueError("iterations must ascend")
        return self


class RenderJob(StrictModel):
    """What the making of distortion data reads of the configuration."""

    device: Literal["cpu", "cuda"] = Field(default="cpu", description="where the reconstruction runs")
    representation: AnyRepresentationSettings = Field(description="the reconstruction")
    renders: RenderSettings = Field(description="when it is rendered")


class TrainingSettings(StrictModel):
    """Optimisation of the network. The length is in steps, never in seconds, so that a run can be repeated."""

    backbone_weights: Literal["auto", "pretrained", "scratch"] = Field(
        default="pretrained",
        description="those of a local file, without which the row of the method that uses the scorer holds the reason "
        "alone; those if there are some, else random ones; or random ones",
    )
    backbone_tag: str | None = Field(
        default=None,
        description="which of timm's pretrained weights; null: dist_450e_in1k for RepViT, lvd142m for DINOv2",
    )
    backbone_frozen: bool | None = Field(
        default=None, description="keep the backbone as it is; null: keep it if and only if it is pretrained"
    )
    cache_features: bool = Field(
        default=False,
        description="with a frozen backbone: encode whole images once and crop their features, where CrossScore "
        "encodes each crop; far faster, but the features of all images take room on disk, beside the weights, until "
        "the training ends",
    )
    resize: ResizeSettings = Field(
        default=ResizeSettings(side="short", pixels=540), description="size of the images before they are cropped"
    )
    crop: int = Field(default=518, ge=PATCH, multiple_of=PATCH, description="side of the square crops in pixels")
    references: ReferenceSettings = Field(default=ReferenceSettings(), description="reference images of a query")
    reference_pool: Literal["scene", "captured"] = Field(
        default="scene",
        description="references are drawn from all photographs of the scene, or from those its reconstruction has seen",
    )
    steps: PositiveInt = Field(default=20000, description="optimisation steps")
    batch: PositiveInt = Field(default=128, description="query images in a step")
    queries_per_set: PositiveInt = Field(
        default=1, description="query images of one scene that share a set of references in a step; divides `batch`"
    )
    learning_rate: PositiveFloat = Field(default=5e-4, description="learning rate of AdamW (weight decay 0.01)")
    schedule: Literal["constant", "cosine"] = Field(
        default="constant", description="learning rate over the steps: constant as in the paper, or a half cosine to 0"
    )
    warmup: NonNegativeInt = Field(
        default=0, description="steps at the start in which the learning rate grows linearly"
    )
    centered: NonNegativeFloat = Field(
        default=0.0,
        description="weight of a second term, the error of image scores less the mean of their set: renderings of one "
        "moment, as the candidates of a choice are; 0 leaves it out, as CrossScore does",
    )
    evaluations: PositiveInt = Field(default=5, description="number of times the held-out error is measured")
    precision: Literal["float32", "bfloat16"] = Field(
        default="float32",
        description="bfloat16 computes the network's products in it (torch.autocast); weights and errors stay float32",
    )
    processes: PositiveInt = Field(
        default=1,
        description="processes that share the sets of each step, on CUDA with a GPU each; the errors are the same to "
        "rounding. The backbone must be frozen",
    )

    @model_validator(mode="after")
    def _sets_divide(self) -> Self:
        if self.batch % self.queries_per_set:
            raise ValueError(f"queries_per_set ({self.queries_per_set}) must divide batch ({self.batch})")
        if self.centered and self.queries_per_set < 2:
            raise ValueError("centered compares the queries of a set: queries_per_set must be 2 or more")
        return self


class ScorerSettings(StrictModel):
    """One trained scorer."""

    published: bool = Field(
        default=True,
        description="where published weights of this scorer are at hand (see `avs weights list`), use them and do not "
        "train; there are some for dinov2, CrossScore's",
    )
    network: AnyNetwork = Field(default=RepViTSettings(), description="architecture, named by its backbone")
    training: TrainingSettings = Field(default=TrainingSettings(), description="optimisation")
    seed: NonNegativeInt = Field(default=0, description="seed of the initial weights and of all random choices")

    @model_validator(mode="after")
    def _tag_is_heard(self) -> Self:
        if self.training.backbone_tag is not None:
            if isinstance(self.network, EfficientNetLite0Settings):
                raise ValueError(
                    f"backbone_tag: there is but one set of weights of {self.network.backbone}; leave it out"
                )
            if self.training.backbone_weights == "scratch":
                raise ValueError("backbone_tag: backbone_weights scratch takes no weights; leave one of them out")
        return self
