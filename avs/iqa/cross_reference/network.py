"""The cross-reference network: predicts the SSIM map of a rendering from photographs of other views.

Architecture of CrossScore (arXiv 2404.14409) on its own backbone, or on the low-latency one of "Active View Selector"
(arXiv 2506.19844): tokens of 14x14 pixels, a two-layer transformer decoder in which the query image's tokens attend to
those of all reference images, and a head that gives 14x14 values in 0..1 per token.
"""

from __future__ import annotations

import copy
from typing import cast

import torch
from torch import Tensor, nn
from torch.nn import functional

from avs.iqa.cross_reference.backbones import Backbone, build_backbone
from avs.iqa.cross_reference.position_codes import PositionCodes
from avs.iqa.cross_reference.scorer_settings import ENCODED_AT_ONCE, PATCH, AnyNetwork, DINOv2Settings


class DecoderLayer(nn.Module):
    """A layer of a transformer decoder: post-norm, no dropout, as ``nn.TransformerDecoderLayer`` computes it.

    It differs in that the keys and values of the reference tokens are computed apart: once for a photograph, however
    many images are compared with it.
    """

    def __init__(self, width: int, heads: int, hidden: int) -> None:
        """Build a layer of ``heads`` attention heads and a feed-forward part of width ``hidden``."""
        super().__init__()
        self.self_attention = nn.MultiheadAttention(width, heads, batch_first=True)
        self.cross_attention = nn.MultiheadAttention(width, heads, batch_first=True)
        self.feed_forward = nn.Sequential(nn.Linear(width, hidden), nn.ReLU(), nn.Linear(hidden, width))
        self.norms = nn.ModuleList(nn.LayerNorm(width) for _ in range(3))

    def memory(self, references: Tensor) -> Tensor:
        """Return the keys and values of reference tokens ``[s, tokens, width]``: ``[s, tokens, 2 width]``."""
        attention, width = self.cross_attention, references.shape[-1]
        return functional.linear(references, attention.in_proj_weight[width:], attention.in_proj_bias[width:])

    def forward(self, queries: Tensor, memory: Tensor, absent: Tensor | None) -> Tensor:
        """Return the new query tokens.

        Args:
            queries: ``[n, tokens, width]``, one row per image.
            memory: ``[s, tokens, 2 width]`` from ``memory``; s divides n, and n/s successive images share a row.
            absent: ``[s, tokens]`` bool, True where a reference token does not count; None if nowhere.
        """
        attended, _ = self.self_attention(queries, queries, queries, need_weights=False)
        x: Tensor = self.norms[0](queries + attended)
        together = x.reshape(len(memory), -1, x.shape[-1])
        x = self.norms[1](x + self._compared(together, memory, absent).reshape(x.shape))
        x = self.norms[2](x + self.feed_forward(x))
        return x

    def _compared(self, queries: Tensor, memory: Tensor, absent: Tensor | None) -> Tensor:
        """Return what the cross-attention of ``queries`` ``[s, tokens, width]`` reads in ``memory``."""
        attention, width = self.cross_attention, queries.shape[-1]
        projected = functional.linear(queries, attention.in_proj_weight[:width], attention.in_proj_bias[:width])
        query, key, value = (
            part.reshape(*part.shape[:2], attention.num_heads, -1).transpose(1, 2)
            for part in (projected, *memory.chunk(2, dim=-1))
        )
        counts = None if absent is None else ~absent[:, None, None]
        read = functional.scaled_dot_product_attention(query, key, value, counts)
        compared: Tensor = attention.out_proj(read.transpose(1, 2).flatten(2))
        return compared


class CrossReferenceNetwork(nn.Module):
    """Predicts SSIM maps without the true image.

    ``encode`` turns images into tokens, ``memory`` tokens of reference images into what the decoder reads of them, and
    ``predict`` compares the tokens of query images with that; so all that depends on a reference image alone is
    computed once, however often it is compared with.
    """

    feature_means: Tensor
    feature_deviations: Tensor

    def __init__(self, settings: AnyNetwork, backbone: Backbone) -> None:
        """Build the parts behind ``backbone``, with weights drawn from torch's generator (see ``build_network``)."""
        super().__init__()
        self.settings = settings
        self.backbone = backbone
        width = settings.channels
        # The paper projects each of RepViT's feature maps, resizes and adds. Resizing before projecting is the same, as
        # both are linear, and cheaper. CrossScore takes DINOv2's tokens as they are.
        projected = not isinstance(settings, DINOv2Settings)
        self.projections = nn.ModuleList(
            nn.Linear(channels, width) if projected else nn.Identity() for channels in backbone.channels
        )
        if settings.standardized:
            self.register_buffer("feature_means", torch.zeros(sum(backbone.channels)))
            self.register_buffer("feature_deviations", torch.ones(sum(backbone.channels)))
        self.positions = PositionCodes(width, settings.position_size, settings.position_seed)
        self.decoder = nn.ModuleList(
            DecoderLayer(width, settings.heads, settings.hidden) for _ in range(settings.layers)
        )
        self.head = nn.Sequential(
            nn.Linear(width, width), nn.LeakyReLU(0.01), nn.Linear(width, PATCH * PATCH), nn.Sigmoid()
        )

    def encode(self, images: Tensor) -> Tensor:
        """Return the tokens of ``images``: ``tokens(features(images))``."""
        return self.tokens(self.features(images))

    def features(self, images: Tensor) -> Tensor:
        """Return what the backbone says of each token: its feature maps, resized to the grid of tokens and joined.

        The paper's grid is (h/14, w/14); as in CrossScore the quotients are rounded down. So the last rows and columns
        of pixels (fewer than 14) get no score of their own; the feature maps are resized as a whole, not cropped.

        Where the backbone learns nothing, it sees some images after others, since nothing is kept for gradients: a step
        of the paper has 768 crops of 518 pixels, which at once take a backbone of 259 bytes a pixel 53 GB.

        Args:
            images: ``[n, 3, height, width]`` in 0..1, sRGB, at least 14 pixels a side.

        Returns:
            ``[n, height // 14, width // 14, sum of the backbone's channels]``.

        Raises:
            ValueError: an image is smaller than a token.
        """
        rows, columns = images.shape[-2] // PATCH, images.shape[-1] // PATCH
        if not rows or not columns:
            raise ValueError(f"images of {tuple(images.shape[-2:])} pixels are smaller than a token of {PATCH}")
        learns = torch.is_grad_enabled() and any(parameter.requires_grad for parameter in self.backbone.parameters())
        if learns or len(images) <= ENCODED_AT_ONCE:
            return self._on_tokens(images, rows, columns)
        return torch.cat([self._on_tokens(part, rows, columns) for part in torch.split(images, ENCODED_AT_ONCE)])

    def _on_tokens(self, images: Tensor, rows: int, columns: int) -> Tensor:
        """Return the backbone's feature maps of images, resized to the grid of tokens and joined."""
        resized = [
            features
            if features.shape[-2:] == (rows, columns)
            else functional.interpolate(features, (rows, columns), mode="bilinear")
            for features in self.backbone(self.normalized(images))
        ]
        return torch.cat(resized, dim=1).permute(0, 2, 3, 1).contiguous()

    def standardize(self, features: Tensor) -> None:
        """Let tokens be made of channels with the mean 0 and the deviation 1 that ``features`` ``[n, channels]`` have.

        A channel that hardly differs among them is divided by a hundredth of the median deviation, lest it drown others
        where it does.
        """
        deviations = features.std(dim=0)
        self.feature_means.copy_(features.mean(dim=0))
        self.feature_deviations.copy_(deviations.clamp(min=max(1e-6, 0.01 * float(deviations.median()))))

    def normalized(self, images: Tensor) -> Tensor:
        """Return the backbone's input: images in 0..1, less its mean, over its deviation, in its precision."""
        told = (self.backbone.mean, self.backbone.deviation)
        mean, deviation = (images.new_tensor(values).view(3, 1, 1) for values in told)
        normal: Tensor = (images - mean) / deviation
        return normal.to(self.positions.codes.dtype)

    def tokens(self, features: Tensor) -> Tensor:
        """Project ``features`` ``[n, rows, columns, channels]`` to the width of a token and add the position codes."""
        if self.settings.standardized:
            features = (features - self.feature_means) / self.feature_deviations
        codes: Tensor = self.positions(*features.shape[1:3])
        tokens = codes.permute(0, 2, 3, 1)
        for part, projection in zip(
            torch.split(features, list(self.backbone.channels), dim=-1), self.projections, strict=True
        ):
            tokens = tokens + projection(part)
        return tokens

    def memory(self, references: Tensor) -> Tensor:
        """Return keys and values for all decoder layers.

        Args:
            references: ``[..., channels]``, tokens from ``encode``.

        Returns:
            ``[..., 2 layers channels]``, token by token.
        """
        return torch.cat([cast(DecoderLayer, layer).memory(references) for layer in self.decoder], dim=-1)

    def predict(self, queries: Tensor, memory: Tensor, absent: Tensor | None = None) -> Tensor:
        """Return the predicted SSIM maps of query images.

        Args:
            queries: ``[n, rows, columns, channels]``, tokens from ``encode``.
            memory: ``[s, tokens, 2 layers channels]`` from ``memory``, the tokens of all reference images, one after
                another; their order does not matter. s divides n: n/s successive query images share a row.
            absent: ``[s, tokens]`` bool, True where ``memory`` is only filled up; None if nowhere.

        Returns:
            ``[n, 14 rows, 14 columns]`` in 0..1.
        """
        count, rows, columns, _ = queries.shape
        tokens = queries.flatten(1, 2)
        for layer, part in zip(self.decoder, memory.chunk(len(self.decoder), dim=-1), strict=True):
            tokens = layer(tokens, part, absent)
        patches: Tensor = self.head(tokens).view(count, rows, columns, PATCH, PATCH)
        return patches.transpose(2, 3).reshape(count, rows * PATCH, columns * PATCH)

    def with_backbone(self, backbone: Backbone) -> CrossReferenceNetwork:
        """Return a copy of this network whose backbone is ``backbone``."""
        copied = copy.deepcopy(self)
        copied.backbone = backbone
        return copied


def build_network(settings: AnyNetwork, seed: int, backbone: Backbone | None = None) -> CrossReferenceNetwork:
    """Return a network with random weights that depend on ``seed`` alone; torch's global generator stays as it is.

    Args:
        settings: the architecture.
        seed: of the initial weights.
        backbone: use this one instead of a random one.
    """
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return CrossReferenceNetwork(settings, backbone or build_backbone(settings))
