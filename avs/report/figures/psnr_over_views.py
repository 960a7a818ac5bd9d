"""Draws the test PSNR over the number of captured views."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avs.report.collect import read_episodes
from avs.report.figures.curves import Curve, Panel, panels
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
_STYLE: dict[Any, Any] = {
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


def write_psnr_over_views(episodes: Sequence[Path], methods: Sequence[str], out: Path) -> None:
    """Write ``out`` with the suffixes ``.pdf`` and ``.png``: a pair of panels for each data set and budget.

    The upper panel has the mean test PSNR over scenes and seeds against the number of captured views, measured just
    before the next view is added; the last point, with a dot, is the end of the optimisation. The lower panel has the
    difference to the mean of the methods in the same scene with the same seed; its band is the interval of
    ``avs.report.intervals``, over scenes or over seeds as the panel says. Differences between scenes, which are larger
    than those between methods, are thus not in the band. Scenes with a smaller budget have panels of their own, so that
    every point of a curve is a mean over the same scenes. Equal records give equal bytes.

    Args:
        episodes: ``episode.json`` files, of any data sets.
        methods: identifiers of the methods, in the order of the legend.
        out: path of the figure without suffix.

    Raises:
        UserError: no episodes; or a record is missing, damaged, or not comparable with the others of its data set.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    drawn = [panel for collected in read_episodes(episodes, methods) for panel in panels(collected)]
    with mpl.rc_context(_STYLE):
        columns = min(len(drawn), _MOST_COLUMNS)
        size = (max(_PANEL_SIZE[0] * columns, 4.2), _PANEL_SIZE[1] * -(-len(drawn) // columns) + 0.4)
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        _draw(figure, drawn, methods, columns)
        for suffix, metadata in _METADATA.items():
            with atomic_path(out.with_name(out.name + suffix)) as temporary:
                figure.savefig(temporary, format=suffix[1:], metadata=dict(metadata))


def _draw(figure: Figure, drawn: Sequence[Panel], methods: Sequence[str], columns: int) -> None:
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
        _dress(upper, lower, drawn[index], first=column == 0)
    _legend(figure, [(labels[method], styles[method]) for method in methods if method in labels])


def _draw_curve(upper: Axes, lower: Axes, curve: Curve, style: dict[str, Any]) -> None:
    dot = {"color": style["color"], "zorder": style["zorder"], "markersize": 3.0}
    for axes, values in ((upper, curve.mean), (lower, curve.difference)):
        axes.plot(curve.views, values, **style)
        axes.plot(curve.views[-1:], values[-1:], "o", clip_on=False, **dot)
    if curve.low is not None and curve.high is not None:
        lower.fill_between(curve.views, curve.low, curve.high, color=style["color"], alpha=0.13, linewidth=0)


def _dress(upper: Axes, lower: Axes, panel: Panel, first: bool) -> None:
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
    if first:
        upper.set_ylabel("test PSNR (dB)")
        lower.set_ylabel("difference to the\nmean of methods (dB)")


def _legend(figure: Figure, entries: Sequence[tuple[str, dict[str, Any]]]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Line2D | Patch] = [Line2D([], [], label=label, **style) for label, style in entries]
    handles.append(Line2D([], [], marker="o", color="#999999", markersize=3, linestyle="", label="end of optimisation"))
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
