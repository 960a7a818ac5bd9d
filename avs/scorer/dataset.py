"""Training batches: crops of renderings, their SSIM maps, and crops of photographs to compare with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from avs.errors import UserError
from avs.scorer.distortions import Distortions, decoded
from avs.scorer.images import resized, to_tensor
from avs.scorer.settings import ResizeSettings, TrainingSettings


@dataclass(frozen=True)
class Batch:
    """One training step's data: s sets of q query crops; the queries of a set share k reference crops.

    Attributes:
        queries: ``[s, q, 3, crop, crop]`` in 0..1.
        maps: ``[s, q, crop, crop]`` true SSIM in 0..1.
        references: ``[s, k, 3, crop, crop]`` in 0..1; black where there was no photograph left.
        present: ``[s, k]`` bool, which references count.
    """

    queries: Tensor
    maps: Tensor
    references: Tensor
    present: Tensor

    def to(self, device: str) -> Batch:
        """Return the batch on ``device``."""
        return Batch(self.queries.to(device), self.maps.to(device), self.references.to(device), self.present.to(device))


class Sampler:
    """Draws batches from the distortion data of several scenes, in an order that its generator alone decides."""

    def __init__(self, scenes: list[Distortions], settings: TrainingSettings, rng: np.random.Generator) -> None:
        """Resize all images once.

        Raises:
            UserError: a scene's images are smaller than a crop.
        """
        self._settings = settings
        self._rng = rng
        self._scenes = [_Prepared(scene, settings) for scene in scenes]

    def batch(self) -> Batch:
        """Draw the next batch: for each set a scene, a moment, references, and renderings of other views."""
        sets = [self._set() for _ in range(self._settings.batch // self._settings.queries_per_set)]
        queries, maps, references, present = (torch.stack(parts) for parts in zip(*sets, strict=True))
        return Batch(queries.float() / 255.0, maps, references.float() / 255.0, present)

    def _set(self) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        scene = self._scenes[int(self._rng.integers(len(self._scenes)))]
        moment = int(self._rng.integers(len(scene.rows)))
        rows, references = self._draw(scene, moment)
        queries, maps = [], []
        for row in rows:
            top, left = self._corner(scene.renderings[row])
            queries.append(_crop(scene.renderings[row], top, left, self._settings.crop))
            maps.append(_crop(scene.maps[row], top, left, self._settings.crop))
        crops = [
            _crop(scene.photographs[i], *self._corner(scene.photographs[i]), self._settings.crop) for i in references
        ]
        black = torch.zeros_like(crops[0])
        crops += [black] * (self._settings.references.count - len(references))
        present = torch.arange(len(crops)) < len(references)
        if self._settings.references.pad == "black":
            present[:] = True
        return torch.stack(queries), torch.stack(maps), torch.stack(crops), present

    def _draw(self, scene: _Prepared, moment: int) -> tuple[list[int], list[int]]:
        """Draw renderings and photographs of one moment, such that no photograph shows the view of a rendering.

        The first rendering is drawn before the photographs, the others from what these leave.
        """
        first = int(self._rng.choice(scene.rows[moment]))
        pool = scene.captured[moment] if self._settings.reference_pool == "captured" else range(len(scene.photographs))
        others = np.array([image for image in pool if image != scene.images[first]])
        references: list[int] = self._rng.permutation(others)[: self._settings.references.count].tolist()
        left = [row for row in scene.rows[moment] if scene.images[row] not in references]
        more = self._settings.queries_per_set - 1
        return [first, *self._rng.choice(left, more, replace=len(left) < more).tolist()], references

    def _corner(self, image: Tensor) -> tuple[int, int]:
        """Draw the upper left corner of a crop."""
        top, left = (int(self._rng.integers(side - self._settings.crop + 1)) for side in image.shape[-2:])
        return top, left


class _Prepared:
    """A scene's images, resized, as tensors; its renderings by moment."""

    def __init__(self, scene: Distortions, settings: TrainingSettings) -> None:
        self.photographs = [_bytes(image, settings.resize) for image in scene.photographs]
        self.renderings = [_bytes(image, settings.resize) for image in scene.renderings]
        self.maps = [resized_map(decoded(code), settings.resize) for code in scene.maps]
        self.images = scene.images
        self.captured = [moment.captured for moment in scene.moments]
        moment_of = np.array(scene.moment_of)
        self.rows = [np.flatnonzero(moment_of == moment) for moment in range(len(scene.moments))]
        side = min(min(image.shape[-2:]) for image in self.photographs)
        if side < settings.crop:
            fault = f"its images have a side of {side} pixels after resizing, crops have {settings.crop}"
            raise UserError(f"scene {scene.scene}", fault, "lower training.crop, or raise training.resize.pixels")


def resized_map(values: npt.NDArray[np.float32], settings: ResizeSettings) -> Tensor:
    """Resize a map ``[height, width]`` as its image."""
    return resized(torch.from_numpy(values)[None, None], settings)[0, 0]


def _bytes(image: npt.NDArray[np.uint8], settings: ResizeSettings) -> Tensor:
    """Return the resized image as ``[3, height, width]`` uint8: four times more images fit in memory than as floats."""
    return (resized(to_tensor(image[None]), settings)[0] * 255.0).round().to(torch.uint8)


def _crop(image: Tensor, top: int, left: int, side: int) -> Tensor:
    return image[..., top : top + side, left : left + side]
