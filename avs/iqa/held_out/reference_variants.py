"""A network's predictions for all renderings of a scene, compared with one choice of photographs or another."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from torch import Tensor

from avs.iqa.cross_reference.distortions import Distortions, batches, captured_references, decoded
from avs.iqa.cross_reference.trained_scorer import CrossReferenceScorer
from avs.iqa.cross_reference.training_batches import resized_map
from avs.iqa.held_out.held_out_settings import ReferencesVariant
from avs.system.seeds import seed_of

FloatArray = npt.NDArray[np.float64]


@dataclass
class Predicted:
    """Predictions of one variant, collected rendering by rendering.

    Attributes:
        scores: ``[renderings]`` predicted SSIM.
    """

    scores: FloatArray
    _sums: FloatArray = field(default_factory=lambda: np.zeros(6))
    _error: float = 0.0

    def add(self, row: int, predicted: npt.NDArray[np.float32], true: npt.NDArray[np.float32]) -> None:
        """Take in the predicted and the true map of a rendering, ``[rows, columns]`` each."""
        self.scores[row] = predicted.mean(dtype=np.float64)
        one, other = predicted.astype(np.float64).ravel(), true.astype(np.float64).ravel()
        self._error += float(np.abs(one - other).sum())
        self._sums += [len(one), one.sum(), other.sum(), one @ one, other @ other, one @ other]

    @property
    def pixel_error(self) -> float:
        """Mean absolute error over all pixels."""
        return self._error / float(self._sums[0])

    @property
    def pixel_pearson(self) -> float | None:
        """Pearson's correlation over all pixels, or None where one of both is constant."""
        count, one, other, squares, other_squares, products = self._sums.tolist()
        variances = (squares - one * one / count) * (other_squares - other * other / count)
        return float((products - one * other / count) / np.sqrt(variances)) if variances > 0 else None


def predict_variants(
    scorer: CrossReferenceScorer,
    data: Distortions,
    other: Distortions,
    variants: Mapping[str, ReferencesVariant],
    pad: bool = False,
) -> dict[str, Predicted]:
    """Return a network's predictions for every rendering, by the name of the variant; each rendering is encoded once.

    Args:
        scorer: the network.
        data: of the scene.
        other: of another scene, for references of a wrong scene.
        variants: what renderings are compared with.
        pad: whether black images take the place of photographs that are too few, as CrossScore has them.
    """
    wanted = {variant.choice == "wrong" for variant in variants.values() if variant.count}
    sources = {wrong: _encoded(scorer, other if wrong else data) for wrong in wanted}
    black = scorer.encode(np.zeros_like(data.photographs[0])[None])[0]
    choosers = {
        name: _chooser(data, other, variant, name, sources.get(variant.choice == "wrong", []), black, pad)
        for name, variant in variants.items()
    }
    found = {name: Predicted(np.empty(len(data))) for name in variants}
    for rows in batches(data, scorer.batch):
        queries = scorer.queries(np.stack([data.renderings[row] for row in rows]))
        for name, choose in choosers.items():
            maps = scorer.compare(queries, [choose(row) for row in rows])
            for row, values in zip(rows, maps, strict=True):
                true = resized_map(decoded(data.maps[row]), scorer.resize).numpy()
                found[name].add(row, values, true[: values.shape[0], : values.shape[1]])
    return found


def _encoded(scorer: CrossReferenceScorer, data: Distortions) -> list[Tensor]:
    """Return what the network reads of each photograph of a scene."""
    return [scorer.encode(image[None])[0] for image in data.photographs]


def _chooser(
    data: Distortions,
    other: Distortions,
    variant: ReferencesVariant,
    name: str,
    encoded: list[Tensor],
    black: Tensor,
    pad: bool,
) -> Callable[[int], list[Tensor]]:
    """Return what gives each rendering its references, of the encoded photographs and a black image."""
    rng = np.random.default_rng(seed_of("references", data.scene, name))

    def choose(row: int) -> list[Tensor]:
        chosen = [encoded[image] for image in chosen_images(data, other, row, variant, rng)]
        missing = variant.count - len(chosen) if pad else 0
        return chosen + [black] * max(missing, int(not chosen))

    return choose


def chosen_images(
    data: Distortions, other: Distortions, row: int, variant: ReferencesVariant, rng: np.random.Generator
) -> list[int]:
    """Return the numbers of the photographs that a rendering is compared with; its own is never among them."""
    if variant.choice == "wrong":
        drawn: list[int] = rng.permutation(len(other.photographs))[: variant.count].tolist()
        return drawn
    return captured_references(data, row, variant.choice, rng)[: variant.count]
