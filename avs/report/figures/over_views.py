"""Draws curves over the number of captured views: a pair of plots for each set of scenes, names at the lines' ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avs.report.figures.curves import Curve, Panel
from avs.report.figures.end_labels import EndLabel, label_ends
from avs.report.figures.figure_files import STYLE, axes_in, save_figure
from avs.report.figures.group_legend import write_group_legend
from avs.report.figures.method_lines import emphasised, line_styles
from avs.report.figures.picture_grid import shortened
from avs.report.formats.plain_text import one_line
from avs.report.intervals import CONFIDENCE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLUMNS = 2
_LEFT, _PLOT, _LETTER = 0.64, 1.86, 0.05  # inches: what stands left of a plot, the plot, and a letter of a label
_NUMBERS = 0.36  # inches for the numbers of an axis
_BOLD = 1.2  # times as wide as others
_MOST_LETTERS, _LEADER = 24, 0.14  # of a label; inches of the line that leads to it
_TITLE, _BETWEEN, _BELOW = 0.2, 0.16, 0.34  # inches
_UPPER, _LEAST_LOWER, _LABEL = 1.35, 1.1, 0.098  # inches: heights of the plots, and of a label
_LEGEND = 0.3  # inches
_MOST_OF_BANDS = 1.6  # times the farthest curve from zero


@dataclass(frozen=True)
class Wording:
    """What a figure of curves says.

    Attributes:
        upper: label of the upper axis.
        lower: label of the lower axis.
        end: what the dot at the end of a curve means.
    """

    upper: str
    lower: str
    end: str


@dataclass(frozen=True)
class _Layout:
    """Sizes in inches: the label column, one panel with its labels, the lower plot, one row of panels."""

    labels: float
    width: float
    lower: float
    row: float


def draw_over_views(drawn: Sequence[Panel], reference: str | None, wording: Wording, out: Path) -> None:
    """Write ``out`` with the suffixes ``.pdf`` and ``.png``: a pair of panels for each data set and budget.

    The upper plot has the curves, the lower one their differences to the mean of the methods, with the name of each
    method at the end of its line. Emphasised are the reference method and the best two, with their intervals.

    Args:
        drawn: the panels.
        reference: identifier of the method that the tables compare with, or None.
        wording: what the figure says.
        out: path of the figure without suffix.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        columns = max(1, min(len(drawn), _COLUMNS))
        rows = -(-len(drawn) // columns)
        layout = _layout(drawn, reference)
        figure = Figure(figsize=(columns * layout.width, rows * layout.row + _LEGEND))
        for index, panel in enumerate(drawn):
            row, column = divmod(index, columns)
            _draw_panel(figure, panel, reference, wording, layout, (column * layout.width, row * layout.row))
        curves = [curve for panel in drawn for curve in panel.curves]
        write_group_legend(figure, curves, wording.end, borderpad=0.2)
        save_figure(figure, out)


def _layout(drawn: Sequence[Panel], reference: str | None) -> _Layout:
    strong = [emphasised(panel.curves, reference) for panel in drawn]
    letters = [
        len(_label(curve)) * (_BOLD if curve.method in bold else 1.0)
        for panel, bold in zip(drawn, strong, strict=True)
        for curve in panel.curves
    ]
    labels = _LEADER + 0.04 + max(letters, default=0.0) * _LETTER
    lower = max(_LEAST_LOWER, _LABEL * max((len(panel.curves) for panel in drawn), default=0))
    row = _TITLE + _UPPER + _BETWEEN + lower + _BELOW
    return _Layout(labels, _LEFT + _PLOT + labels, lower, row)


def _label(curve: Curve) -> str:
    return shortened(one_line(curve.label), _MOST_LETTERS)


def _draw_panel(
    figure: Figure,
    panel: Panel,
    reference: str | None,
    wording: Wording,
    layout: _Layout,
    corner: tuple[float, float],
) -> None:
    """Draw one pair of plots; ``corner`` is its upper left one, in inches from that of the figure."""
    left, top = corner[0] + _LEFT, corner[1] + _TITLE
    upper = axes_in(figure, (left, top, _PLOT, _UPPER))
    lower = axes_in(figure, (left, top + _UPPER + _BETWEEN, _PLOT, layout.lower))
    styles, strong = line_styles(panel.curves, reference), emphasised(panel.curves, reference)
    for curve in panel.curves:
        _draw_curve(upper, lower, curve, styles[curve.method], banded=curve.method in strong)
    _dress(upper, lower, panel, wording)
    for axes, height, values, shown in (
        (upper, _UPPER, "mean", strong),
        (lower, layout.lower, "difference", [curve.method for curve in panel.curves]),
    ):
        labels = [
            EndLabel(
                _label(curve),
                (float(curve.views[-1]), float(getattr(curve, values)[-1])),
                styles[curve.method]["color"],
                curve.method in strong,
            )
            for curve in panel.curves
            if curve.method in shown and len(curve.views)
        ]
        label_ends(axes, labels, _LABEL / height, _LEADER / _PLOT)


def _draw_curve(upper: Axes, lower: Axes, curve: Curve, style: dict[str, Any], banded: bool) -> None:
    dot = {"color": style["color"], "zorder": style["zorder"], "markersize": 2.5}
    for axes, values in ((upper, curve.mean), (lower, curve.difference)):
        axes.plot(curve.views, values, **style)
        axes.plot(curve.views[-1:], values[-1:], "o", clip_on=False, **dot)
    if banded and curve.low is not None and curve.high is not None:
        lower.fill_between(curve.views, curve.low, curve.high, color=style["color"], alpha=0.13, linewidth=0)


def _dress(upper: Axes, lower: Axes, panel: Panel, wording: Wording) -> None:
    from matplotlib.ticker import MaxNLocator

    upper.set_title(panel.title, loc="left", fontsize=7.5, pad=3)
    upper.sharex(lower)
    upper.tick_params(labelbottom=False)
    lower.set_xlabel("captured views", fontsize=7, labelpad=1)
    # Of two seeds or scenes an interval can be ten times as wide as all curves together: it may leave the frame.
    reach = max((abs(value) for curve in panel.curves for value in curve.difference), default=0.0)
    low, high = lower.get_ylim()
    if reach == 0:  # of a single method
        lower.set_ylim(-1.0, 1.0)
    else:
        lower.set_ylim(max(low, -_MOST_OF_BANDS * reach), min(high, _MOST_OF_BANDS * reach))
    lower.axhline(0.0, color="#999999", linewidth=0.6, zorder=1)
    lower.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 4, 5, 10]))
    for axes, text in ((upper, wording.upper), (lower, wording.lower)):
        axes.set_ylabel(text, fontsize=7)
        axes.yaxis.set_label_coords(-_NUMBERS / _PLOT, 0.5)
        axes.tick_params(labelsize=6.5, pad=2)
    if panel.over is not None:
        told = f"band: {CONFIDENCE:.0%} interval over {panel.over}"
        lower.set_title(told, loc="right", fontsize=5.5, color="#555555", pad=2)
