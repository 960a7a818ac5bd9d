"""Draws the coverage of explorations over the actions of the robot."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from avs.report.collect_explorations import Explorations, read_explorations
from avs.report.figures.figure_files import STYLE, save_figure
from avs.report.formats.plain_text import one_line
from avs.slam.loop.exploration_record import ExplorationRecord

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PANEL = (3.3, 2.6)  # inches
# The palette of Okabe and Ito, which readers with any colour vision tell apart; lines differ in dashes as well.
_COLOURS = ("#0072B2", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#D55E00")
_DASHES = ((0, (5, 1.5)), (0, (1, 1.2)), (0, (4, 1.2, 1, 1.2)), (0, (3, 1, 1, 1, 1, 1)), "-")
_REFERENCE: dict[str, Any] = {"color": "#888888", "linestyle": (0, (1, 1)), "linewidth": 1.0}


def write_slam_over_steps(records: Sequence[Path], buildings: Sequence[str], methods: Sequence[str], out: Path) -> None:
    """Write ``out`` with the suffixes ``.pdf`` and ``.png``: two panels for each building.

    The upper one has the share of the visible surface within the threshold of a Gaussian's centre, the lower one the
    share that the depth camera has seen, both in percent: the mean over seeds, and a band from the least to the
    greatest where there are several. Equal records give equal bytes.

    Args:
        records: ``exploration.json`` files.
        buildings: names, in the order of panels.
        methods: identifiers, in the order of the legend.
        out: path of the figure without suffix.

    Raises:
        UserError: no record; or one is missing, damaged or not comparable.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    explorations = read_explorations(records)
    with mpl.rc_context(STYLE):
        size = (max(_PANEL[0] * len(buildings), 4.2), 2 * _PANEL[1] + 0.5)
        figure = Figure(figsize=size, layout="constrained")
        axes = figure.subplots(2, len(buildings), squeeze=False, sharey="row")
        for column, building in enumerate(buildings):
            axes[0][column].set_title(one_line(building), loc="left")
            _draw(axes[0][column], explorations, building, methods, "scr_means")
            _draw(axes[1][column], explorations, building, methods, "seen")
            axes[1][column].set_xlabel("actions")
        axes[0][0].set_ylabel("SCR by centres (%)")
        axes[1][0].set_ylabel("seen (%)")
        handles, labels = axes[0][0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2 if len(buildings) < 2 else 4)
        save_figure(figure, out)


def _draw(axes: Axes, explorations: Explorations, building: str, methods: Sequence[str], quantity: str) -> None:
    styles = _styles(explorations, methods)
    for method in methods:
        records = explorations.of(building, method)
        if not records:
            continue
        steps = np.unique(np.concatenate([[point.step for point in record.curve] for record in records]))
        values = np.array([_at(record, quantity, steps) for record in records])
        axes.plot(steps, values.mean(axis=0), label=one_line(explorations.label(method)), **styles[method])
        if len(records) > 1:
            colour = styles[method]["color"]
            axes.fill_between(steps, values.min(axis=0), values.max(axis=0), color=colour, alpha=0.13, linewidth=0)


def _styles(explorations: Explorations, methods: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return the line style of each method, fixed by its place; upper references are grey."""
    return {
        method: {"color": _COLOURS[place % 6], "linestyle": _DASHES[place % 5], "linewidth": 1.4}
        if explorations.ranked(method)
        else _REFERENCE
        for place, method in enumerate(methods)
    }


def _at(record: ExplorationRecord, quantity: str, steps: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    """Return a quantity in percent at ``steps``; after an early end it stays as it was."""
    own = [float(point.step) for point in record.curve]
    values = [100.0 * getattr(point, quantity) for point in record.curve]
    return np.asarray(np.interp(steps.astype(np.float64), own, values))
