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
        self._scenes = scenes
        self._photographs = [[_bytes(image, settings.resize) for image in scene.photographs] for scene in scenes]
        self._renderings = [[_bytes(image, settings.resize) for image in scene.renderings] for scene in scenes]
        self._maps = [[resized_map(decoded(code), settings.resize) for code in scene.maps] for scene in scenes]
        self._of_moment = [_by_moment(scene) for scene in scenes]
        for scene, images in zip(scenes, self._photographs, strict=True):
            side = min(min(image.shape[1:]) for image in images)
            if side < settings.crop:
                fault = f"its images have a side of {side} pixels after resizing, crops have {settings.crop}"
                raise UserError(f"scene {scene.scene}", fault, "lower training.crop, or raise training.resize.pixels")

    def batch(self) -> Batch:
        """Draw the next batch: for each set a scene, a moment, references, and renderings of other views."""
        sets = [self._set() for _ in range(self._settings.batch // self._settings.queries_per_set)]
        queries, maps, references, present = (torch.stack(parts) for parts in zip(*sets, strict=True))
        return Batch(queries.float() / 255.0, maps, references.float() / 255.0, present)

    def _set(self) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        rng, settings = self._rng, self._settings
        number = int(rng.integers(len(self._scenes)))
        scene = self._scenes[number]
        moment = int(rng.integers(len(scene.moments)))
        references = self._references(scene, moment)
        others = [row for row in self._of_moment[number][moment] if scene.images[row] not in references]
        rows = rng.choice(others, settings.queries_per_set, replace=len(others) < settings.queries_per_set)
        queries, maps = [], []
        for row in rows:
            image = self._renderings[number][row]
            top, left = self._corner(image)
            queries.append(_crop(image, top, left, settings.crop))
            maps.append(_crop(self._maps[number][row], top, left, settings.crop))
        photographs = [self._photographs[number][image] for image in references]
        crops = [_crop(image, *self._corner(image), settings.crop) for image in photographs]
        missing = settings.references.count - len(crops)
        crops += [torch.zeros(3, settings.crop, settings.crop, dtype=torch.uint8)] * missing
        present = torch.arange(len(crops)) < len(photographs)
        if settings.references.pad == "black":
            present[:] = True
        return torch.stack(queries), torch.stack(maps), torch.stack(crops), present

    def _references(self, scene: Distortions, moment: int) -> list[int]:
        """Draw photographs; at least one rendering of the moment keeps out of them."""
        pool = (
            scene.moments[moment].captured
            if self._settings.reference_pool == "captured"
            else range(len(scene.photographs))
        )
        shown = {scene.images[row] for row in self._of_moment[self._scenes.index(scene)][moment]}
        drawn: list[int] = self._rng.permutation(np.array(pool))[: self._settings.references.count].tolist()
        return drawn if shown - set(drawn) else drawn[:-1]

    def _corner(self, image: Tensor) -> tuple[int, int]:
        """Draw the upper left corner of a crop."""
        spare = (image.shape[-2] - self._settings.crop + 1, image.shape[-1] - self._settings.crop + 1)
        return int(self._rng.integers(spare[0])), int(self._rng.integers(spare[1]))


def resized_map(values: npt.NDArray[np.float32], settings: ResizeSettings) -> Tensor:
    """Resize a map ``[height, width]`` as its image."""
    return resized(torch.from_numpy(values)[None, None], settings)[0, 0]


def _bytes(image: npt.NDArray[np.uint8], settings: ResizeSettings) -> Tensor:
    """Return the resized image as ``[3, height, width]`` uint8: four times more images fit in memory than as floats."""
    return (resized(to_tensor(image[None]), settings)[0] * 255.0).round().to(torch.uint8)


def _crop(image: Tensor, top: int, left: int, side: int) -> Tensor:
    return image[..., top : top + side, left : left + side]


def _by_moment(scene: Distortions) -> list[list[int]]:
    """Return the renderings of each moment."""
    rows: list[list[int]] = [[] for _ in scene.moments]
    for row, moment in enumerate(scene.moment_of):
        rows[moment].append(row)
    return rows
