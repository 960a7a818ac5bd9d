"""Use of a trained scorer: tokens of photographs once, scores of renderings in batches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn.utils.rnn import pad_sequence

from avs.iqa.cross_reference.backbones import fused
from avs.iqa.cross_reference.network import CrossReferenceNetwork
from avs.iqa.cross_reference.scorer_settings import Precision
from avs.iqa.resizing import Pixels, ResizeSettings, resized, to_tensor

_CACHED_TOKENS = 4096
"""Reference tokens that a CPU decodes at once: more leave its cache, which makes it a sixth slower at 518 px."""


class CrossReferenceScorer:
    """Scores images against photographs of other views of the same scene."""

    def __init__(
        self,
        network: CrossReferenceNetwork,
        resize: ResizeSettings,
        batch: int = 8,
        device: str = "cpu",
        precision: Precision = "float32",
    ) -> None:
        """Prepare ``network`` for inference.

        Args:
            network: trained; it is not changed.
            resize: how images are resized first.
            batch: images in one pass; bounds the memory.
            device: ``cpu`` or ``cuda``.
            precision: of weights and tokens; images are normalised, and maps averaged, in more.
        """
        self.resize = resize
        self.batch = batch
        self.device = device
        merged = network.with_backbone(fused(network.backbone))
        self.network = merged.to(device, dtype=getattr(torch, precision)).eval()

    @torch.inference_mode()
    def encode(self, images: Pixels) -> list[Tensor]:
        """Return what the network reads of each reference image, for ``maps`` and ``score``.

        Args:
            images: ``[n, height, width, 3]`` sRGB, uint8 or floats in 0..1.

        Returns:
            n tensors ``[tokens, values]`` on the scorer's device.
        """
        return [each for _, batch in self._tokens(images) for each in self.network.memory(batch.flatten(1, 2))]

    @torch.inference_mode()
    def maps(self, images: Pixels, references: Sequence[Sequence[Tensor]]) -> npt.NDArray[np.float32]:
        """Return the predicted SSIM maps.

        Args:
            images: ``[n, height, width, 3]`` sRGB, uint8 or floats in 0..1.
            references: for each image its reference images, from ``encode``; at least one, of any sizes.

        Returns:
            ``[n, 14 rows, 14 columns]`` in 0..1, one value per pixel of the resized image, which is cut to whole tokens
            at its right and lower border.

        Raises:
            ValueError: an image has no reference, or the numbers of images and of lists differ.
        """
        if len(references) != len(images):
            raise ValueError("each image needs a list of at least one reference image")
        parts = [self.compare(queries, [references[row] for row in rows]) for rows, queries in self._tokens(images)]
        return np.concatenate(parts)

    @torch.inference_mode()
    def queries(self, images: Pixels) -> Tensor:
        """Return the tokens of images, ``[n, rows, columns, channels]``, for ``compare``; all in one pass.

        Args:
            images: ``[n, height, width, 3]`` sRGB, uint8 or floats in 0..1.
        """
        batch = resized(to_tensor(images, self.device), self.resize)
        tokens: Tensor = self.network.encode(batch.contiguous(memory_format=torch.channels_last))
        return tokens

    @torch.inference_mode()
    def compare(self, queries: Tensor, references: Sequence[Sequence[Tensor]]) -> npt.NDArray[np.float32]:
        """Return the predicted SSIM maps of images whose tokens are known, as ``maps`` does.

        Raises:
            ValueError: an image has no reference, or the numbers of images and of lists differ.
        """
        if len(references) != len(queries) or not all(references):
            raise ValueError("each image needs a list of at least one reference image")
        joined = [torch.cat(list(each)) for each in references]
        together = len(queries) if self.device != "cpu" else max(1, _CACHED_TOKENS // len(joined[0]))
        predicted = []
        for start in range(0, len(queries), together):
            part = slice(start, start + together)
            values = self.network.predict(queries[part], *_stacked(joined[part]))
            predicted.append(values.float().cpu().numpy())
        return np.concatenate(predicted)

    def score(self, images: Pixels, references: Sequence[Sequence[Tensor]]) -> npt.NDArray[np.float64]:
        """Return ``[n]`` predicted SSIM: the plain mean of each map; arguments as of ``maps``."""
        scores: npt.NDArray[np.float64] = self.maps(images, references).mean(axis=(1, 2), dtype=np.float64)
        return scores

    def _tokens(self, images: Pixels) -> Iterator[tuple[range, Tensor]]:
        """Yield the rows of each batch and their tokens ``[b, rows, columns, channels]``."""
        for start in range(0, len(images), self.batch):
            rows = range(start, min(start + self.batch, len(images)))
            yield rows, self.queries(images[rows.start : rows.stop])


def _stacked(references: list[Tensor]) -> tuple[Tensor, Tensor | None]:
    """Stack token lists ``[t, channels]``; where lengths differ, fill up and return which tokens are absent."""
    lengths = torch.tensor([len(tokens) for tokens in references], device=references[0].device)
    memory = pad_sequence(references, batch_first=True)
    if (lengths == lengths[0]).all():
        return memory, None
    return memory, torch.arange(memory.shape[1], device=memory.device)[None] >= lengths[:, None]
