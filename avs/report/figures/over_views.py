"""Draws curves over the number of captured views in the house's style, and what figures share of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avs.report.figures.curves import Curve, Panel
from avs.report.formats.plain_text import one_line
from avs.report.intervals import CONFIDENCE
from avs.report.methods import presented
from avs.system.files import atomic_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# The palette of Okabe and Ito, which readers with any colour vision tell apart, with two colours of Tol's; lines differ
# in dashes as well, for print without colour. The methods that the paper proposes are solid, thicker and in front.
_PROPOSED_COLOURS = ("#D55E00", "#000000")
# Upper references: grey, thin and behind, told apart by their dashes.
_UNRANKED_COLOURS = ("#888888", "#888888", "#333333", "#333333", "#888888", "#bbbbbb")
_UNRANKED_DASHES = ((0, (1, 1)), (0, (4, 2)), (0, (2, 1)), (0, (5, 1, 1, 1)), (0, (8, 2)), (0, (3, 1, 1, 1, 1, 1)))
_OTHER_COLOURS = ("#0072B2", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#777777", "#882255", "#999933")
# Those with which one colour comes again, three places on in the circle, do not look the same.
_DASHES = ((0, (5, 1.5)), (0, (1, 1.2)), (0, (4, 1.2, 1, 1.2)), (0, (3, 1, 1, 1, 1, 1)), (0, (8, 2)))

_MOST_COLUMNS = 3
_PANEL_SIZE = (3.2, 4.0)  # inches
_LEGEND_LINE, _LEGEND_LETTER = 0.4, 0.048  # inches: a line with its margins, and a letter of its label
_MOST_OF_BANDS = 4.0  # times the farthest curve from zero
STYLE: dict[Any, Any] = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.linewidth": 0.4,
    "grid.color": "#DDDDDD",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "text.parse_math": False,  # labels come from records: a dollar sign is one
    "pdf.fonttype": 42,  # TrueType: text stays text
    "savefig.dpi": 200,
}
# Without dates and versions equal figures are equal bytes.
_METADATA: dict[str, dict[str, None]] = {
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    ".png": {"Software": None},
}


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


def draw_over_views(drawn: Sequence[Panel], methods: Sequence[str], wording: Wording, out: Path) -> None:
    """Write ``out`` with the suffixes ``.pdf`` and ``.png``: a pair of panels for each data set and budget.

    Args:
        drawn: the panels.
        methods: identifiers of the methods, in the order of the legend.
        wording: what the figure says.
        out: path of the figure without suffix.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        columns = max(1, min(len(drawn), _MOST_COLUMNS))
        size = (max(_PANEL_SIZE[0] * columns, 4.2), _PANEL_SIZE[1] * -(-len(drawn) // columns) + 0.4)
        figure = Figure(figsize=size, layout="constrained")
        _draw(figure, drawn, methods, columns, wording)
        save_figure(figure, out)


def draw_notice(text: str, out: Path) -> None:
    """Write a figure that says why there is nothing to draw, in place of one."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.0, 1.0))
        figure.text(0.02, 0.5, text, va="center", wrap=True)
        save_figure(figure, out)


def save_figure(figure: Figure, out: Path) -> None:
    """Write a figure to ``out`` with the suffixes ``.pdf`` and ``.png``; equal figures give equal bytes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    for suffix, metadata in _METADATA.items():
        with atomic_path(out.with_name(out.name + suffix)) as temporary:
            figure.savefig(temporary, format=suffix[1:], metadata=dict(metadata))


def _draw(figure: Figure, drawn: Sequence[Panel], methods: Sequence[str], columns: int, wording: Wording) -> None:
    styles = method_styles(methods)
    rows = -(-len(drawn) // columns)
    axes = figure.subplots(2 * rows, columns, squeeze=False, gridspec_kw={"height_ratios": [3, 2] * rows})
    labels: dict[str, str] = {}
    for index in range(rows * columns):
        row, column = divmod(index, columns)
        upper, lower = axes[2 * row][column], axes[2 * row + 1][column]
        if index >= len(drawn):
            upper.remove()
            lower.remove()
            continue
        if index > 0:
            lower.sharey(axes[1][0])  # differences are to be compared across panels
        for curve in drawn[index].curves:
            labels[curve.method] = one_line(curve.label)
            _draw_curve(upper, lower, curve, styles[curve.method])
        _dress(upper, lower, drawn[index], wording if column == 0 else None)
    entries = [(labels[method], styles[method]) for method in methods if method in labels]
    _legend(figure, entries, wording.end)


def _draw_curve(upper: Axes, lower: Axes, curve: Curve, style: dict[str, Any]) -> None:
    dot = {"color": style["color"], "zorder": style["zorder"], "markersize": 3.0}
    for axes, values in ((upper, curve.mean), (lower, curve.difference)):
        axes.plot(curve.views, values, **style)
        axes.plot(curve.views[-1:], values[-1:], "o", clip_on=False, **dot)
    if curve.low is not None and curve.high is not None:
        lower.fill_between(curve.views, curve.low, curve.high, color=style["color"], alpha=0.13, linewidth=0)


def _dress(upper: Axes, lower: Axes, panel: Panel, wording: Wording | None) -> None:
    from matplotlib.ticker import MaxNLocator

    upper.set_title(panel.title, loc="left")
    upper.sharex(lower)
    upper.tick_params(labelbottom=False)
    lower.set_xlabel("captured views")
    if panel.over is not None:
        lower.set_title(f"band: {CONFIDENCE:.0%} interval over {panel.over}", loc="right", fontsize=6.5, pad=2)
    # Of two seeds or scenes an interval can be ten times as wide as all curves together: it may leave the frame.
    reach = max((abs(value) for curve in panel.curves for value in curve.difference), default=0.0)
    low, high = lower.get_ylim()
    if reach > 0:
        lower.set_ylim(max(low, -_MOST_OF_BANDS * reach), min(high, _MOST_OF_BANDS * reach))
    lower.axhline(0.0, color="#999999", linewidth=0.6, zorder=1)
    lower.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 4, 5, 10]))
    if wording is not None:
        upper.set_ylabel(wording.upper)
        lower.set_ylabel(wording.lower)


def _legend(figure: Figure, entries: Sequence[tuple[str, dict[str, Any]]], end: str) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Line2D | Patch] = [Line2D([], [], label=label, **style) for label, style in entries]
    handles.append(Line2D([], [], marker="o", color="#999999", markersize=3, linestyle="", label=end))
    handles.append(Patch(color="#999999", alpha=0.3, linewidth=0, label=f"{CONFIDENCE:.0%} interval"))
    longest = max(len(str(handle.get_label())) for handle in handles)
    columns = max(1, int(figure.get_figwidth() / (_LEGEND_LINE + longest * _LEGEND_LETTER)))
    figure.legend(handles=handles, loc="outside lower center", ncols=min(columns, len(handles)))


def method_styles(methods: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return the line style of each method, fixed by its place in ``methods``."""
    shown = [presented(method) for method in methods]
    proposed = [method.identifier for method in shown if method.proposed]
    unranked = [method.identifier for method in shown if not method.ranked]
    others = [method.identifier for method in shown if method.ranked and not method.proposed]
    styles: dict[str, dict[str, Any]] = {}
    for index, method in enumerate(proposed):
        colour = _PROPOSED_COLOURS[index % len(_PROPOSED_COLOURS)]
        styles[method] = {"color": colour, "linestyle": "-", "linewidth": 2.0, "zorder": 5}
    for index, method in enumerate(unranked):
        place = index % len(_UNRANKED_COLOURS)
        line = {"color": _UNRANKED_COLOURS[place], "linestyle": _UNRANKED_DASHES[place]}
        styles[method] = {**line, "linewidth": 1.0, "zorder": 2}
    for index, method in enumerate(others):
        # After one round the colours meet other dashes, because their numbers have no common divisor.
        colour, dashes = _OTHER_COLOURS[index % len(_OTHER_COLOURS)], _DASHES[index % len(_DASHES)]
        styles[method] = {"color": colour, "linestyle": dashes, "linewidth": 1.2, "zorder": 3}
    return styles
