"""Training batches: crops of renderings, their SSIM maps, and crops of photographs to compare with."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from avs.iqa.cross_reference.distortions import Distortions, decoded
from avs.iqa.cross_reference.reference_order import reference_order
from avs.iqa.cross_reference.scorer_settings import PATCH, TrainingSettings
from avs.iqa.cross_reference.tensors_on_disk import on_disk
from avs.iqa.resizing import ResizeSettings, resized, target_size, to_tensor
from avs.system.errors import UserError

_ENCODING_BATCH = 8


@dataclass(frozen=True)
class Batch:
    """One training step's data: s sets of q query crops, and k reference crops for a whole set or for each query of it.

    Attributes:
        queries: ``[s, q, 3, crop, crop]`` in 0..1; or ``[s, q, crop / 14, crop / 14, channels]``, the backbone's
            features.
        maps: ``[s, q, crop, crop]`` true SSIM in 0..1.
        references: ``[s, r, k, ...]`` as ``queries``; r is 1, where the queries of a set share them, or q.
        present: ``[s, r, k]`` bool, which references count; the others are black.
    """

    queries: Tensor
    maps: Tensor
    references: Tensor
    present: Tensor

    @property
    def encoded(self) -> bool:
        """Whether queries and references are features, not pixels."""
        return self.queries.shape[-2:] != self.maps.shape[-2:]

    def to(self, device: str) -> Batch:
        """Return the batch on ``device``."""
        return Batch(self.queries.to(device), self.maps.to(device), self.references.to(device), self.present.to(device))


class Sampler:
    """Draws batches from the distortion data of several scenes, in an order that its generator alone decides."""

    def __init__(
        self,
        scenes: list[Distortions],
        settings: TrainingSettings,
        rng: np.random.Generator,
        features: Callable[[Tensor], Tensor] | None = None,
        folder: Path | None = None,
    ) -> None:
        """Take the data; an image is resized when it is drawn for the first time.

        Args:
            scenes: the data.
            settings: sizes and numbers.
            rng: decides every draw.
            features: if given, all images ``[n, 3, height, width]`` in 0..1 pass through it now, and the crops are
                taken of what it returns, ``[n, height // 14, width // 14, channels]``. It is kept on disk, since
                that of forty scenes fills a memory.
            folder: where it is kept; None is where temporary files are.

        Raises:
            UserError: a scene's images are smaller than a crop.
            OSError: there is no room on disk.
        """
        self._settings = settings
        self._rng = rng
        self._unit = 1 if features is None else PATCH
        self._scenes = [_Prepared(scene, settings, features, folder) for scene in scenes]
        black = np.zeros((settings.crop, settings.crop, 3), dtype=np.uint8)
        self._black = _prepared([black], ResizeSettings(pixels=settings.crop), features, folder)(0)

    @property
    def state(self) -> dict[str, Any]:
        """Where the draws are, as JSON can hold it."""
        return dict(self._rng.bit_generator.state)

    @state.setter
    def state(self, state: dict[str, Any]) -> None:
        self._rng.bit_generator.state = state

    def batch(self) -> Batch:
        """Draw the next batch: for each set a scene, a moment, references, and renderings of other views."""
        sets = [self._set() for _ in range(self._settings.batch // self._settings.queries_per_set)]
        queries, maps, references, present = (torch.stack(parts) for parts in zip(*sets, strict=True))
        if queries.dtype == torch.uint8:
            queries, references = (images.movedim(-1, -3).float() / 255.0 for images in (queries, references))
        return Batch(queries, maps, references, present)

    def _set(self) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        scene = self._scenes[int(self._rng.integers(len(self._scenes)))]
        moment = int(self._rng.integers(len(scene.rows)))
        rows, chosen = self._draw(scene, moment)
        queries, maps = zip(*(self._crop(scene.rendering(row), scene.map(row)) for row in rows), strict=True)
        references, present = zip(*(self._references(scene, images) for images in chosen), strict=True)
        return torch.stack(queries), torch.stack(maps), torch.stack(references), torch.stack(present)

    def _references(self, scene: _Prepared, images: Sequence[int]) -> tuple[Tensor, Tensor]:
        """Return crops of photographs ``[k, ...]``, filled up with black ones, and which of them count, ``[k]``."""
        crops = [self._crop(scene.photograph(image))[0] for image in images]
        crops += [self._black] * (self._settings.references.count - len(crops))
        present = torch.arange(len(crops)) < len(images)
        if self._settings.references.pad == "black":
            present[:] = True
        return torch.stack(crops), present

    def _draw(self, scene: _Prepared, moment: int) -> tuple[list[int], list[list[int]]]:
        """Draw renderings and photographs of one moment, such that no photograph shows the view of its rendering.

        Of photographs by chance the set has the same: the first rendering is drawn before them, the others from what
        they leave. The nearest ones are those of each rendering.
        """
        if self._settings.references.choice == "nearest":
            wanted, rows = self._settings.queries_per_set, scene.rows[moment]
            queries: list[int] = self._rng.choice(rows, wanted, replace=len(rows) < wanted).tolist()
            return queries, [self._chosen(scene, moment, scene.images[row]) for row in queries]
        first = int(self._rng.choice(scene.rows[moment]))
        references = self._chosen(scene, moment, scene.images[first])
        left = [row for row in scene.rows[moment] if scene.images[row] not in references]
        more = self._settings.queries_per_set - 1
        return [first, *self._rng.choice(left, more, replace=len(left) < more).tolist()], [references]

    def _chosen(self, scene: _Prepared, moment: int, own: int) -> list[int]:
        """Return the photographs that the rendering of the photograph ``own`` is compared with."""
        told, captured = self._settings.references, self._settings.reference_pool == "captured"
        pool = np.array([image for image in (scene.captured[moment] if captured else scene.every) if image != own])
        order = reference_order(scene.centers[pool], scene.centers[own], told.choice, self._rng)
        chosen: list[int] = pool[order][: told.count].tolist()
        return chosen

    def _crop(self, image: Tensor, similarity: Tensor | None = None) -> tuple[Tensor, Tensor]:
        """Return a random square of ``image`` ``[rows, columns, channels]``, and the same square of its SSIM map."""
        side = self._settings.crop // self._unit
        top, left = (int(self._rng.integers(length - side + 1)) for length in image.shape[:2])
        square = image[top : top + side, left : left + side]
        if similarity is None:
            return square, square
        top, left, side = (number * self._unit for number in (top, left, side))
        return square, similarity[top : top + side, left : left + side]


class _Prepared:
    """A scene's images, resized, as tensors ``[rows, columns, channels]``; its renderings by moment."""

    def __init__(
        self,
        scene: Distortions,
        settings: TrainingSettings,
        features: Callable[[Tensor], Tensor] | None,
        folder: Path | None,
    ) -> None:
        self._maps, self._resize = scene.maps, settings.resize
        shapes = {code.shape for code in scene.maps}
        side = min(min(target_size(height, width, self._resize)) for height, width in shapes)
        if side < settings.crop:
            fault = f"its images have a side of {side} pixels after resizing, crops have {settings.crop}"
            raise UserError(f"scene {scene.scene}", fault, "lower training.crop, or raise training.resize.pixels")
        self.photograph = _prepared(scene.photographs, settings.resize, features, folder)
        self.rendering = _prepared(scene.renderings, settings.resize, features, folder)
        self.images, self.centers = scene.images, scene.centers
        self.every = range(len(scene.photographs))
        self.captured = [moment.captured for moment in scene.moments]
        moment_of = np.array(scene.moment_of)
        self.rows = [np.flatnonzero(moment_of == moment) for moment in range(len(scene.moments))]

    def map(self, row: int) -> Tensor:
        """Return the SSIM map ``[height, width]`` of a rendering."""
        return resized_map(decoded(self._maps[row]), self._resize)


def resized_map(values: npt.NDArray[np.float32], settings: ResizeSettings) -> Tensor:
    """Resize a map ``[height, width]`` as its image."""
    return resized(torch.from_numpy(values)[None, None], settings)[0, 0]


def _prepared(
    images: Sequence[npt.NDArray[np.uint8]],
    settings: ResizeSettings,
    features: Callable[[Tensor], Tensor] | None,
    folder: Path | None,
) -> Callable[[int], Tensor]:
    """Return what gives an image's features, kept on disk; or its pixels as uint8, kept once they were asked for."""
    if features is not None:
        tensors = (resized(to_tensor(image[None]), settings) for image in images)
        return on_disk(_encoded(tensors, features), folder).__getitem__

    @functools.cache
    def pixels(row: int) -> Tensor:
        image = resized(to_tensor(images[row][None]), settings)[0]
        return (image * 255.0).round().to(torch.uint8).permute(1, 2, 0)

    return pixels


def _encoded(images: Iterator[Tensor], features: Callable[[Tensor], Tensor]) -> Iterator[Tensor]:
    """Yield the features of each image ``[1, 3, height, width]``, computed for a few of one size at once."""
    for _, group in itertools.groupby(images, key=lambda image: image.shape):
        while batch := list(itertools.islice(group, _ENCODING_BATCH)):
            yield from features(torch.cat(batch))
