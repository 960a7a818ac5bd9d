"""The job of one held-out scene: every predictor scores every rendering of its distortion data."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from avs.iqa.cross_reference.distortions import Distortions, batches, read_distortions
from avs.iqa.cross_reference.scorer_checkpoint import load_network
from avs.iqa.cross_reference.trained_scorer import CrossReferenceScorer
from avs.iqa.held_out.held_out_record import HeldOutScores, Scored
from avs.iqa.held_out.held_out_settings import STATISTICS, HeldOutJob, ReferencesVariant, ScoredMetric, ScoredNetwork
from avs.iqa.held_out.reference_variants import predict_variants
from avs.iqa.render_statistics.pixel_statistics import PIXEL_STATISTICS
from avs.iqa.render_statistics.regression_file import Sighted, read_regressions
from avs.iqa.render_statistics.regression_fit import ALL_STATISTICS, predicted, statistics_of
from avs.iqa.render_statistics.regression_settings import RegressionSettings
from avs.representations.base import FloatImages
from avs.selection import registry
from avs.selection.choice import notes_of
from avs.selection.contract import Method, Resources, Selector
from avs.system.computed_by import write_computed_by
from avs.system.devices import take_device
from avs.system.errors import UserError
from avs.system.files import file_hash
from avs.system.global_state import unchanged
from avs.system.records import write_record
from avs.system.seeds import seed_global_generators

FloatArray = npt.NDArray[np.float64]

Progress = Callable[[str], None]
"""Takes one line about each predictor."""


@runtime_checkable
class AssessesImages(Protocol):
    """A selector that scores an image by itself, whatever the scene; ``Method.assesses_images`` tells of it."""

    def quality(self, images: FloatImages) -> FloatArray:
        """Return the score ``[n]`` of each of ``images`` ``[n, height, width, 3]`` in 0..1, as ``score`` gives it."""
        ...


_REGRESSIONS: dict[Sighted, str] = {"seen": "Render statistics", "pixels": "Render statistics, pixels alone"}

_PLAIN = {
    "gradient": ("mean gradient", "lowest"),
    "opacity": ("accumulated opacity", "lowest"),
    "distance": ("distance to the nearest captured view", "highest"),
}
"""Columns of the statistics that are scores by themselves: printed name, and which values are taken for bad."""


def write_held_out_scores(
    path: Path, other: Path, settings: HeldOutJob, weights: Mapping[str, Path], out: Path, progress: Progress
) -> None:
    """Let every predictor score the renderings of a held-out scene, and write the record to ``out``.

    What it was computed with goes beside it, to ``*.meta.json``.

    Args:
        path: distortion data of the scene, in the folder of its data set.
        other: those of another held-out scene.
        settings: what scores, and how.
        weights: files of weights, by the identifier of the method.
        out: the record.
        progress: receives one line about each predictor.

    Raises:
        UserError: distortion data or weights are missing or damaged.
    """
    take_device(settings.device)
    data, another = read_distortions(path), read_distortions(other)
    scored = []
    for each in _predictors(data, another, settings, weights):
        progress(f"{data.scene}: {each.label} {each.failure or 'scored'}")
        scored.append(each)
    record = HeldOutScores(
        dataset=path.parent.name,
        scene=data.scene,
        scene_hash=data.scene_hash,
        other_scene=another.scene,
        settings=settings,
        moment=list(data.moment_of),
        candidate=data.candidates.tolist(),
        ssim=data.similarity.tolist(),
        scored=scored,
    )
    write_record(out, record)
    write_computed_by(out, settings.device)


def _predictors(
    data: Distortions, other: Distortions, settings: HeldOutJob, weights: Mapping[str, Path]
) -> Iterator[Scored]:
    for network in settings.networks:
        yield from _by_network(data, other, network, settings, weights[network.method])
    for metric in settings.metrics:
        yield _by_metric(data, metric, settings, weights.get(metric.method))
    resize = (settings.statistics or RegressionSettings()).resize
    statistics = statistics_of(data, resize)
    if settings.statistics is not None:
        yield from _by_regressions(statistics, settings, weights[STATISTICS])
    for name, (label, worst) in _PLAIN.items():
        values = statistics[:, ALL_STATISTICS.index(name)]
        yield Scored.model_validate(
            {"identifier": name, "label": label, "kind": "plain", "worst": worst, "scores": values.tolist()}
        )


def _by_network(
    data: Distortions, other: Distortions, told: ScoredNetwork, settings: HeldOutJob, weights: Path
) -> Iterator[Scored]:
    """Yield what a network says with the references of its method, and with others."""
    network = load_network(weights, told.backbone)
    scorer = CrossReferenceScorer(network, told.resize, settings.evaluation.batch, settings.device, told.precision)
    own = ReferencesVariant(count=told.references.count, choice=told.references.choice)
    pad = told.references.pad == "black"
    variants = {"": own, **settings.evaluation.references}
    hashed = file_hash(weights)
    own_settings = told.model_dump(include={"references", "resize", "precision"})
    notes = notes_of(*_selector(told.method, own_settings, weights, settings.device))
    for name, found in predict_variants(scorer, data, other, variants, pad).items():
        yield Scored(
            identifier=f"{told.method}/{name}" if name else told.method,
            label=f"{told.label}, {name}" if name else told.label,
            kind="references" if name else "network",
            worst="lowest",
            scores=found.scores.tolist(),
            pixel_error=found.pixel_error,
            pixel_pearson=found.pixel_pearson,
            weights_hash=hashed,
            notes=[] if name else notes,
        )


def _by_metric(data: Distortions, told: ScoredMetric, settings: HeldOutJob, weights: Path | None) -> Scored:
    """Return what a metric says; one that fails leaves the others as they are, and the record has the reason."""
    method = registry.find(told.method).method
    scores, failure = None, None
    notes: list[str] = []
    seed_global_generators("method", data.scene, told.method)
    try:
        _, selector = _selector(told.method, told.selector, weights, settings.device)
        if not isinstance(selector, AssessesImages):
            raise UserError(method.label, "gives no quality of an image by itself", "leave out Method.assesses_images")
        values = np.empty(len(data))
        for rows in batches(data, settings.evaluation.batch):
            images = np.stack([data.renderings[row] for row in rows]).astype(np.float32) / np.float32(255.0)
            with unchanged(method.label):
                quality = selector.quality(images)
            values[rows] = _checked(method, quality, len(rows))
        scores, notes = values.tolist(), notes_of(method, selector)
    except UserError as error:
        failure = str(error)
    except Exception as error:  # a plug-in may raise anything
        traceback.print_exc()
        failure = f"{type(error).__name__}: {error}"
    return Scored(
        identifier=told.method,
        label=method.label,
        kind="metric",
        worst=method.chooses,
        scores=scores,
        weights_hash=None if weights is None else file_hash(weights),
        notes=notes,
        failure=failure,
    )


def _selector(
    identifier: str, told: dict[str, Any], weights: Path | None, device: Literal["cpu", "cuda"]
) -> tuple[Method, Selector]:
    """Return a method, and what it selects with under some settings."""
    method = registry.find(identifier).method
    return method, method.selector(registry.create_settings(identifier, told), Resources(weights, device))


def _checked(method: Method, values: object, count: int) -> FloatArray:
    """Return the scores of ``count`` images.

    Raises:
        TypeError: they are something else, or not all finite.
    """
    scores = np.asarray(values, dtype=np.float64)
    if isinstance(values, np.ma.MaskedArray) or scores.shape != (count,) or not np.isfinite(scores).all():
        raise TypeError(f"quality of {method.label} is no array of {count} finite scores, one for each image")
    return scores


def _by_regressions(statistics: FloatArray, settings: HeldOutJob, weights: Path) -> Iterator[Scored]:
    fitted, hashed = read_regressions(weights), file_hash(weights)
    assert settings.statistics is not None  # the caller has looked
    notes = notes_of(*_selector(STATISTICS, settings.statistics.model_dump(), weights, settings.device))
    for name, label in _REGRESSIONS.items():
        regression = fitted.regressions[name]
        if name == "seen" and len(regression.columns) == len(PIXEL_STATISTICS):
            continue  # it sees pixels alone, as the other does
        yield Scored(
            identifier=STATISTICS if name == "seen" else f"{STATISTICS}/{name}",
            label=label,
            kind="regression",
            worst="lowest",
            scores=predicted(regression, statistics).tolist(),
            weights_hash=hashed,
            notes=notes if name == "seen" else [],
        )
