"""The fit of the regressions of SSIM on render statistics to distortion data, and its model card."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from avs.iqa.cross_reference.distortions import Distortions, batches, read_distortions
from avs.iqa.render_statistics.pixel_statistics import PIXEL_STATISTICS, pixel_statistics
from avs.iqa.render_statistics.regression_file import FittedRegressions, RegressionFacts, Sighted, write_regressions
from avs.iqa.render_statistics.regression_settings import COLUMNS, RegressionSettings
from avs.iqa.render_statistics.ssim_regression import FloatArray, Regression, Sample, fit_regression
from avs.iqa.render_statistics.view_geometry import VIEW_GEOMETRY
from avs.iqa.resizing import Pixels, ResizeSettings
from avs.system.files import write_json
from metrics.ranking import mean_within, spearman

Progress = Callable[[str], None]
"""Takes one line about each scene."""

ALL_STATISTICS = (*PIXEL_STATISTICS, *VIEW_GEOMETRY)
"""The names of all that is known of a rendering and its view, in the order of ``all_statistics``."""

_BATCH = 24


def fit_statistics(
    training: Sequence[Path],
    held_out: Sequence[Path],
    weights: Path,
    card: Path,
    settings: RegressionSettings,
    progress: Progress,
) -> None:
    """Fit both regressions, and write them with their model card.

    Args:
        training: distortion data of the scenes that they are fitted to.
        held_out: distortion data of other scenes, which only measure them.
        weights: file to write, as ``read_regressions`` reads it.
        card: model card (JSON) to write.
        settings: what the regressions read.
        progress: receives one line about each scene.

    Raises:
        UserError: distortion data are missing or damaged.
    """
    scenes = [_read(path, settings.resize, progress) for path in training]
    unseen = [_read(path, settings.resize, progress) for path in held_out]
    chosen: dict[Sighted, tuple[str, ...]] = {"seen": columns_seen(settings), "pixels": PIXEL_STATISTICS}
    samples = [scene.sample for scene in scenes]
    regressions = {name: _fitted(samples, columns, settings.penalty) for name, columns in chosen.items()}
    within = {name: [_within(each, scene.sample) for scene in unseen] for name, each in regressions.items()}
    facts = RegressionFacts(
        settings=settings,
        scenes=len(scenes),
        candidates=sum(len(sample.similarity) for sample in samples),
        held_out=len(unseen),
        candidate_spearman={name: _mean(values) for name, values in within.items()},
    )
    write_regressions(weights, FittedRegressions(regressions, facts))
    content = {
        "schema_version": 1,
        "facts": facts.model_dump(mode="json"),
        "training_scenes": [scene.told for scene in scenes],
        "held_out_scenes": [
            scene.told | {"candidate_spearman": {name: values[number] for name, values in within.items()}}
            for number, scene in enumerate(unseen)
        ],
        "coefficients": {
            name: dict(zip(each.columns, each.coefficients.tolist(), strict=True)) for name, each in regressions.items()
        },
    }
    write_json(card, content)


def columns_seen(settings: RegressionSettings) -> tuple[str, ...]:
    """Return the names of all statistics that a regression with these settings reads, in order."""
    seen = {column for sight in settings.sees for column in COLUMNS[sight]}
    return (*PIXEL_STATISTICS, *(name for name in VIEW_GEOMETRY if name in seen))


def all_statistics(images: Pixels, geometry: FloatArray, resize: ResizeSettings) -> FloatArray:
    """Return the columns of ``ALL_STATISTICS`` ``[n, 14]`` of n renderings with their views' geometry ``[n, 5]``."""
    return np.concatenate([pixel_statistics(images, resize), geometry], axis=1)


def predicted(regression: Regression, statistics: FloatArray) -> FloatArray:
    """Return the predicted SSIM ``[n]`` from ``statistics`` ``[n, 14]``, of which a regression reads its own."""
    return regression.predict(statistics[:, [ALL_STATISTICS.index(name) for name in regression.columns]])


def statistics_of(data: Distortions, resize: ResizeSettings) -> FloatArray:
    """Return the columns of ``ALL_STATISTICS`` of every rendering of a scene, ``[renderings, 14]``."""
    found = np.empty((len(data), len(ALL_STATISTICS)))
    for rows in batches(data, _BATCH):
        images = np.stack([data.renderings[row] for row in rows])
        found[rows] = all_statistics(images, data.geometry[rows], resize)
    return found


@dataclass(frozen=True)
class _Scene:
    """The candidates of a scene, and what a card tells of it."""

    sample: Sample
    told: dict[str, Any]


def _read(path: Path, resize: ResizeSettings, progress: Progress) -> _Scene:
    data = read_distortions(path)
    rows = np.flatnonzero(data.candidates)
    sample = Sample(statistics_of(data, resize)[rows], data.similarity[rows], np.array(data.moment_of)[rows])
    progress(f"{data.scene}: {len(rows)} candidates, SSIM {sample.similarity.mean():.3f}")
    return _Scene(sample, {"name": data.scene, "sha256": data.scene_hash, "candidates": len(rows)})


def _fitted(samples: Sequence[Sample], columns: tuple[str, ...], penalty: float) -> Regression:
    places = [ALL_STATISTICS.index(name) for name in columns]
    read = [Sample(sample.statistics[:, places], sample.similarity, sample.moment) for sample in samples]
    return fit_regression(read, columns, penalty)


def _within(regression: Regression, sample: Sample) -> float | None:
    scores = predicted(regression, sample.statistics)
    return mean_within(spearman, scores, sample.similarity, sample.moment).value


def _mean(values: Sequence[float | None]) -> float | None:
    defined = [value for value in values if value is not None]
    return float(np.mean(defined)) if defined else None
