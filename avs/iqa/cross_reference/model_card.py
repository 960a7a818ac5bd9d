"""The model card: what a scorer was trained on, how, and how well it predicts on scenes it has not seen."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.stats import pearsonr, spearmanr

from avs.iqa.cross_reference.distortions import Distortions, batches, captured_references, decoded
from avs.iqa.cross_reference.network import CrossReferenceNetwork
from avs.iqa.cross_reference.scorer_settings import ScorerSettings
from avs.iqa.cross_reference.trained_scorer import CrossReferenceScorer
from avs.iqa.cross_reference.training_batches import resized_map
from avs.system.files import file_hash
from metrics.ranking import mean_within, spearman

_BATCH = 8
_PIXELS = 64


@dataclass(frozen=True)
class Prediction:
    """Predicted and true quality of one held-out rendering.

    Attributes:
        scene: number of its scene.
        moment: number of its moment within the scene.
        captured: whether its view had been captured at that moment; if not, it was a candidate.
        predicted: predicted SSIM of the image.
        true: its true SSIM, over all pixels.
        pixels: ``[p, 2]`` predicted and true values of some pixels.
    """

    scene: int
    moment: int
    captured: bool
    predicted: float
    true: float
    pixels: npt.NDArray[np.float32]


def model_card(
    network: CrossReferenceNetwork,
    settings: ScorerSettings,
    backbone: Path | None,
    scenes: list[Distortions],
    held_out: list[Distortions],
    curve: Sequence[Any],
    device: str,
) -> dict[str, Any]:
    """Return the card's content; it depends on the data, the settings and the kind of machine alone."""
    predictions = list(predict_held_out(network, settings, held_out, device))
    within = candidate_spearman(predictions)
    return {
        "schema_version": 1,
        "settings": settings.model_dump(mode="json"),
        "parameters": sum(parameter.numel() for parameter in network.parameters()),
        "backbone_weights": "random" if backbone is None else {"file": backbone.name, "sha256": file_hash(backbone)},
        "training_scenes": [_summary(scene) for scene in scenes],
        "held_out_scenes": [
            _summary(scene) | {"candidate_spearman": round(within[number], 6) if number in within else None}
            for number, scene in enumerate(held_out)
        ],
        "mean_absolute_error": [
            {"step": point.step, "training": round(point.training, 6), "held_out": round(point.held_out, 6)}
            for point in curve
        ],
        "held_out": {key: None if value is None else round(value, 6) for key, value in agreement(predictions).items()},
    }


def predict_held_out(
    network: CrossReferenceNetwork, settings: ScorerSettings, held_out: list[Distortions], device: str
) -> Iterator[Prediction]:
    """Score whole held-out renderings against photographs captured at their moment, without their own."""
    training, told = settings.training, settings.training.references
    scorer = CrossReferenceScorer(network, training.resize, _BATCH, device)
    rng = np.random.default_rng([settings.seed, 2])
    for number, scene in enumerate(held_out):
        tokens = [scorer.encode(photograph[None])[0] for photograph in scene.photographs]
        black = scorer.encode(np.zeros_like(scene.photographs[0])[None]) if told.pad == "black" else []
        for rows in batches(scene, _BATCH):
            references = [captured_references(scene, row, told.choice, rng)[: told.count] for row in rows]
            predicted = scorer.maps(
                np.stack([scene.renderings[row] for row in rows]),
                [[*(tokens[image] for image in images), *black * (told.count - len(images))] for images in references],
            )
            for row, values in zip(rows, predicted, strict=True):
                true = decoded(scene.maps[row])
                same = resized_map(true, training.resize).numpy()[: values.shape[0], : values.shape[1]]
                moment = scene.moment_of[row]
                yield Prediction(
                    scene=number,
                    moment=moment,
                    captured=scene.images[row] in scene.moments[moment].captured,
                    predicted=float(values.mean(dtype=np.float64)),
                    true=float(true.mean(dtype=np.float64)),
                    pixels=rng.permutation(np.stack([values, same], axis=-1).reshape(-1, 2))[:_PIXELS],
                )


def agreement(predictions: Sequence[Prediction]) -> dict[str, float | None]:
    """Return how well predictions agree with the truth.

    ``pearson`` and ``spearman`` over all images; ``pixel_pearson`` and ``pixel_spearman`` over sampled pixels;
    ``candidate_spearman``: over the views not yet captured at one moment of one scene, mean over moments and then over
    scenes, with its standard error over scenes, ``candidate_spearman_error``. The last is what a choice among
    candidates depends on; the first are easier, because quality rises in the course of a reconstruction. A correlation
    with a constant is None, and so is an error of fewer than two scenes.
    """
    images = np.array([(item.predicted, item.true) for item in predictions])
    pixels = np.concatenate([item.pixels for item in predictions])
    scenes = np.array(list(candidate_spearman(predictions).values()))
    return {
        "images": float(len(images)),
        "pearson": _correlation(pearsonr, images),
        "spearman": _correlation(spearmanr, images),
        "pixel_pearson": _correlation(pearsonr, pixels),
        "pixel_spearman": _correlation(spearmanr, pixels),
        "candidate_spearman": float(scenes.mean()) if len(scenes) else None,
        "candidate_spearman_error": float(scenes.std(ddof=1) / np.sqrt(len(scenes))) if len(scenes) > 1 else None,
        "mean_absolute_error": float(np.abs(images[:, 0] - images[:, 1]).mean()),
    }


def candidate_spearman(predictions: Sequence[Prediction]) -> dict[int, float]:
    """Return, by scene, the rank correlation among the candidates of a moment, mean over moments where it is defined.

    A moment needs three candidates at least; a scene without any is left out.
    """
    groups: dict[int, list[tuple[float, float, int]]] = {}
    for item in predictions:
        if not item.captured:
            groups.setdefault(item.scene, []).append((item.predicted, item.true, item.moment))
    within = {scene: mean_within(spearman, *zip(*group, strict=True)).value for scene, group in groups.items()}
    return {scene: value for scene, value in within.items() if value is not None}


def _correlation(statistic: Callable[..., Any], pairs: npt.NDArray[np.floating[Any]]) -> float | None:
    """Return a correlation of the columns of ``pairs`` ``[n, 2]``."""
    if (np.ptp(pairs, axis=0) == 0).any():
        return None
    return float(statistic(pairs[:, 0], pairs[:, 1]).statistic)


def _summary(scene: Distortions) -> dict[str, Any]:
    return {
        "name": scene.scene,
        "sha256": scene.scene_hash,
        "photographs": len(scene.photographs),
        "renderings": len(scene),
        "moments": len(scene.moments),
        "mean_ssim": round(float(np.mean([decoded(code).mean() for code in scene.maps])), 6),
    }
