"""Image encoders of the cross-reference network, and where their ImageNet weights are found.

RepViT (arXiv 2307.09283) is the low-latency one of the paper; a further one is one more entry of ``BACKBONES``.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal, cast

import safetensors
import safetensors.torch
import torch
from torch import Tensor, nn

from avs.compatibility import prepare_torchvision
from avs.errors import UserError

WEIGHTS_VARIABLE = "AVS_WEIGHTS"
"""Environment variable: a folder of ImageNet weights, named as timm's models: ``<model>.<tag>.safetensors``."""

REPVIT_TAPS = {"A": (2, 6, 22, 25), "B": (1, 5, 21, 24)}
"""The paper's "layers 2, 6, 22, and 25" as blocks counted from 0 without the stem: literally, or with the stem as 0."""


class Backbone(nn.Module):
    """Maps normalised images to feature maps at several depths.

    Attributes:
        channels: channels of each feature map.
    """

    channels: tuple[int, ...]

    def forward(self, images: Tensor) -> list[Tensor]:
        """Return one ``[n, channels[i], rows, columns]`` feature map per entry of ``channels``.

        Args:
            images: ``[n, 3, height, width]``, normalised with ImageNet's mean and deviation.
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


BACKBONES: dict[str, Callable[[Literal["A", "B"], Path | None], Backbone]] = {"repvit_m0_9": RepViT}


def find_weights(backbone: str, tag: str) -> Path | None:
    """Return the local file of a backbone's ImageNet weights, or None; never uses the network.

    It looks in the folder that ``AVS_WEIGHTS`` names, then in the cache of huggingface_hub, where timm keeps them.
    """
    folder = os.environ.get(WEIGHTS_VARIABLE)
    if folder and (path := Path(folder) / f"{backbone}.{tag}.safetensors").is_file():
        return path
    from huggingface_hub import try_to_load_from_cache

    cached = try_to_load_from_cache(f"timm/{backbone}.{tag}", "model.safetensors")
    return Path(cached) if isinstance(cached, str) else None


def _load(model: nn.Module, path: Path) -> None:
    """Load a timm checkpoint without its classifier into ``model``."""
    try:
        state = safetensors.torch.load_file(path)
        model.load_state_dict({key: value for key, value in state.items() if not key.startswith("head.")})
    except (OSError, safetensors.SafetensorError) as error:
        raise UserError(path, f"not a readable safetensors file ({error})", "fetch it again") from error
    except RuntimeError as error:
        fault = f"does not fit this backbone ({str(error).splitlines()[0]})"
        raise UserError(path, fault, "use timm's weights of the model that its name says") from error


def open_residual_branches(backbone: Backbone) -> None:
    """Give the residual branches of a random backbone that will stay random a weight of one half.

    timm starts the last batch norm of each branch at zero, as training likes it: the mixing of channels then does
    nothing.
    """
    with torch.no_grad():
        for module in backbone.modules():
            if isinstance(module, nn.BatchNorm2d) and not module.weight.any():
                module.weight.fill_(0.5)


def fused(backbone: Backbone) -> Backbone:
    """Return an equivalent copy for inference, batch norms and parallel branches merged into single convolutions."""
    from timm.utils.model import reparameterize_model

    merged = cast(Backbone, reparameterize_model(backbone))
    merged.eval()
    # channels last is the faster layout for convolutions in large batches
    for parameter in merged.parameters():
        if parameter.ndim == 4:
            parameter.data = parameter.data.contiguous(memory_format=torch.channels_last)
    return merged
