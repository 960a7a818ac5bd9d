"""Render statistics: the candidate to which a linear regression on plain statistics gives the lowest SSIM."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from pydantic import Field, PositiveInt

from avs.iqa.render_statistics.regression_settings import RegressionSettings
from avs.selection.batched_rendering import render_in_batches
from avs.selection.contract import Method, Resources, Settings, State
from avs.system.errors import UserError

if TYPE_CHECKING:
    from avs.iqa.render_statistics.regression_file import FittedRegressions


class StatisticsSettings(RegressionSettings, Settings):
    """Settings of the method, those of the fit among them."""

    batch: PositiveInt = Field(default=8, description="candidates rendered and scored at once; bounds the memory")


class StatisticsSelector:
    """Lowest SSIM by the regression that sees all it may see.

    Attributes:
        notes: what a reader of its results should know.
    """

    def __init__(self, settings: StatisticsSettings, fitted: FittedRegressions) -> None:
        """Select with fitted regressions."""
        self._settings = settings
        self._regression = fitted.regressions["seen"]
        facts = fitted.facts
        seen = ", ".join(settings.sees) or "pixels alone"
        rho = facts.candidate_spearman["seen"]
        self.notes = (
            f"Render statistics: fitted by this run to {facts.candidates} renderings of {facts.scenes} training "
            f"scenes; beside pixels it sees: {seen}; held out ({facts.held_out} scenes), the rank correlation with the "
            f"true SSIM among the candidates of one moment is {'undefined' if rho is None else f'{rho:.2f}'}",
        )

    def score(self, state: State) -> npt.NDArray[np.float64]:
        """Return the predicted SSIM of each candidate, ``[n]``; of the representation only ``render`` is used."""
        from avs.iqa.render_statistics.regression_fit import all_statistics, predicted
        from avs.iqa.render_statistics.view_geometry import view_geometry

        scores = np.empty(len(state.candidates))
        captured = state.captured.cameras
        for rows, rendering in render_in_batches(state.representation, state.candidates, self._settings.batch):
            geometry = view_geometry(rendering, state.candidates[rows], captured)
            # as the renderings that it was fitted to, in eight bits
            images = np.round(np.clip(rendering.rgb, 0.0, 1.0) * 255.0).astype(np.uint8)
            scores[rows] = predicted(self._regression, all_statistics(images, geometry, self._settings.resize))
        return scores


def _build(settings: StatisticsSettings, resources: Resources) -> StatisticsSelector:
    """Return a selector with the regressions of ``resources.weights``.

    Raises:
        UserError: they are absent, damaged, or were fitted with other settings than the method's.
    """
    from avs.iqa.render_statistics.regression_file import read_regressions

    path = resources.weights
    if path is None:
        raise UserError("Render statistics", "needs the regressions of avs statistics_fit", "pass --weights")
    fitted = read_regressions(path)
    if fitted.facts.settings != RegressionSettings.taken_from(settings):
        raise UserError(path, "was fitted with other settings than selectors.statistics has", "fit it again")
    return StatisticsSelector(settings, fitted)


METHODS = {
    "statistics": Method(
        label="Render statistics",
        group="2D-based",
        source=(
            "A plain baseline of this suite, not the paper's: the SSIM that a ridge regression predicts from nine "
            "statistics of the rendering's pixels, from its accumulated opacity and depth, and from the distance and "
            "angle to the nearest captured view; fitted to the renderings on which the run trains its scorers."
        ),
        chooses="lowest",
        build=_build,
        settings=StatisticsSettings,
        fallback="statistics",
        scene_units=True,
    )
}
