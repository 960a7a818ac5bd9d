"""Curves over views, such as of test PSNR, for figures: which scenes are averaged, and what the band means."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from avs.nvs.record import Episode
from avs.report.collect import Cell, Episodes, image_mean
from avs.report.intervals import Over, interval, printed_over
from avs.report.methods import presented
from avs.selection.contract import UNRANKED


@dataclass(frozen=True)
class Curve:
    """One method in one panel.

    Attributes:
        method: identifier.
        label: printed name.
        group: row group in the tables, such as 3D-based.
        views: ``[n]`` numbers of captured views, ascending.
        mean: ``[n]`` decibels or another unit, mean over seeds and scenes, or median over scenes.
        difference: ``[n]`` in the same unit, mean difference to the mean of the methods in the same scene with the same
            seed; oracles are no part of that mean.
        low: ``[n]`` lower end of the interval of ``difference``; None with one scene and one seed.
        high: ``[n]`` its upper end, or None.
    """

    method: str
    label: str
    group: str
    views: npt.NDArray[np.int64]
    mean: npt.NDArray[np.float64]
    difference: npt.NDArray[np.float64]
    low: npt.NDArray[np.float64] | None
    high: npt.NDArray[np.float64] | None


@dataclass(frozen=True)
class Panel:
    """The scenes of one data set that share a budget.

    Attributes:
        title: data set, number of scenes and of seeds.
        over: over what the intervals of its curves are (``avs.report.intervals``), or None if they have none.
        curves: one for each method, all over the same scenes and seeds.
    """

    title: str
    over: Over | None
    curves: list[Curve]


def psnr_by_views(episode: Episode) -> dict[int, float]:
    """Return the mean test PSNR by number of views; the last measurement with a number of views counts."""
    values = {point.views: image_mean(point, "psnr") for point in episode.curve}
    return {views: value for views, value in values.items() if value is not None}


Values = Callable[[Episode], Mapping[int, float]]
"""What a curve has of an episode, by number of views."""


def panels(
    episodes: Episodes, values: Values = psnr_by_views, middle: Callable[[Sequence[float]], Any] = np.mean
) -> list[Panel]:
    """Return one panel for each budget of a data set, largest first.

    Scenes with different budgets are not averaged: a curve whose later points lack the scenes that ended would jump
    where they end. Every method is averaged over the scenes and seeds that all methods of the panel have, so that
    curves can be compared.

    Args:
        episodes: of one data set.
        values: what a curve has of each episode.
        middle: what a curve is over scenes, of the means over seeds.
    """
    budgets = sorted({episode.budget for episode in episodes.all}, reverse=True)
    found = (_panel(episodes, budget, values, middle) for budget in budgets)
    return [panel for panel in found if panel is not None]


def _panel(episodes: Episodes, budget: int, values: Values, middle: Callable[[Sequence[float]], Any]) -> Panel | None:
    cells = {
        method: {cell: episode for cell, episode in of_method.items() if episode.budget == budget}
        for method, of_method in episodes.cells.items()
    }
    cells = {method: of_method for method, of_method in cells.items() if of_method}
    shared = sorted(set.intersection(*(set(of_method) for of_method in cells.values())))
    if not shared:
        return None
    scenes, seeds = {scene for scene, _ in shared}, {seed for _, seed in shared}
    names = f"{len(scenes)} scenes" if len(scenes) > 1 else next(iter(scenes))
    title = f"{episodes.dataset}: {names}, {len(seeds)} seed{'s' if len(seeds) > 1 else ''}"
    measured = {method: {cell: values(found[cell]) for cell in shared} for method, found in cells.items()}
    told = {  # several programs can call themselves the same
        method: next(iter(of_method.values())).model_copy(update={"label": presented(method, episodes).label})
        for method, of_method in cells.items()
    }
    ranked = {
        method: measured[method] for method, of_method in cells.items() if of_method[shared[0]].group not in UNRANKED
    }
    reference = list((ranked or measured).values())
    over = printed_over(len(scenes), min(sum(cell[0] == scene for cell in shared) for scene in scenes))
    curves = [_curve(told[method], measured[method], reference, shared, over, middle) for method in cells]
    return Panel(title, over, curves)


def _curve(
    told: Episode,
    own: dict[Cell, Mapping[int, float]],
    methods: list[dict[Cell, Mapping[int, float]]],
    cells: list[Cell],
    over: Over | None,
    middle: Callable[[Sequence[float]], Any],
) -> Curve:
    # An oracle may be measured at numbers of views at which no method is.
    views = sorted(
        set.intersection(*(own[cell].keys() & {n for of_method in methods for n in of_method[cell]} for cell in cells))
    )
    scenes = sorted({scene for scene, _ in cells})
    mean, difference, bands = [], [], []
    for number in views:
        # Methods that add several views at once lack some numbers of views.
        reference = {
            cell: np.mean([of_method[cell][number] for of_method in methods if number in of_method[cell]])
            for cell in cells
        }
        by_scene = [[own[cell][number] for cell in cells if cell[0] == scene] for scene in scenes]
        centred = [[own[cell][number] - reference[cell] for cell in cells if cell[0] == scene] for scene in scenes]
        mean.append(middle([float(np.mean(values)) for values in by_scene]))
        difference.append(np.mean([np.mean(values) for values in centred]))
        bands.append(None if over is None else interval(centred, over))
    known = [band for band in bands if band is not None]
    return Curve(
        told.method,
        told.label,
        told.group,
        np.array(views, dtype=np.int64),
        np.array(mean),
        np.array(difference),
        np.array([band.low for band in known]) if known else None,
        np.array([band.high for band in known]) if known else None,
    )
