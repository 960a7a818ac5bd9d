"""Ridge regression of the true SSIM of renderings on their statistics, each moment with a level of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_LEAST_DEVIATION = 1e-9


@dataclass(frozen=True)
class Sample:
    """The candidates of one scene.

    Attributes:
        statistics: ``[n, c]`` finite.
        similarity: ``[n]`` true SSIM, mean of a map clipped to 0..1 pixel by pixel.
        moment: ``[n]`` number of the moment at which each was rendered.
    """

    statistics: FloatArray
    similarity: FloatArray
    moment: npt.NDArray[np.int64]


@dataclass(frozen=True)
class Regression:
    """A linear function of some statistics.

    Attributes:
        columns: names of the c statistics that it reads.
        means: ``[c]``, over the training scenes.
        deviations: ``[c]`` positive, likewise.
        coefficients: ``[c]`` of the standardised statistics.
        level: its value where each statistic is at its mean.
    """

    columns: tuple[str, ...]
    means: FloatArray
    deviations: FloatArray
    coefficients: FloatArray
    level: float

    def predict(self, statistics: FloatArray) -> FloatArray:
        """Return the predicted SSIM ``[n]`` of ``statistics`` ``[n, c]``; nominally in 0..1, not clipped."""
        standard = (statistics - self.means) / self.deviations
        return np.asarray(self.level + (standard * self.coefficients).sum(axis=1))


def fit_regression(samples: Sequence[Sample], columns: tuple[str, ...], penalty: float) -> Regression:
    """Fit a regression whose coefficients order the candidates of a moment.

    A choice is among the candidates of one moment, while most of the variance of SSIM lies between moments: an early
    reconstruction is bad everywhere. Statistics and SSIM are therefore taken less their means over each moment (the
    within estimator of panel data), so that what tells moments apart has no part in the coefficients. Scenes count
    alike, however many candidates they have.

    Args:
        samples: of the training scenes.
        columns: names of the statistics, as the columns of each sample.
        penalty: weight of the sum of squared coefficients.

    Raises:
        ValueError: there is no sample.
    """
    every = np.concatenate([sample.statistics for sample in samples])
    means: FloatArray = every.mean(axis=0)
    deviations: FloatArray = np.maximum(every.std(axis=0), _LEAST_DEVIATION)
    products = np.zeros((len(columns), len(columns)))
    moments = np.zeros(len(columns))
    for sample in samples:
        centered = _centered((sample.statistics - means) / deviations, sample.moment)
        similarity = _centered(sample.similarity[:, None], sample.moment)[:, 0]
        products += centered.T @ centered / (len(centered) * len(samples))
        moments += centered.T @ similarity / (len(centered) * len(samples))
    coefficients = np.asarray(np.linalg.solve(products + penalty * np.eye(len(columns)), moments), dtype=np.float64)
    levels = [
        sample.similarity.mean() - ((sample.statistics.mean(axis=0) - means) / deviations) @ coefficients
        for sample in samples
    ]
    return Regression(columns, means, deviations, coefficients, float(np.mean(levels)))


def _centered(values: FloatArray, moment: npt.NDArray[np.int64]) -> FloatArray:
    """Return ``values`` ``[n, c]`` less the mean of their moment."""
    result = values.copy()
    for number in np.unique(moment):
        result[moment == number] -= values[moment == number].mean(axis=0)
    return result
