"""Draws the average ranks of methods on an axis, with bars over those that Nemenyi's test cannot tell apart."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from avs.report.collect import Episodes, read_dataset
from avs.report.figures.captions import told_of_machines, write_caption
from avs.report.figures.figure_files import STYLE, draw_notice, save_figure
from avs.report.figures.picture_grid import shortened
from avs.report.formats.plain_text import one_line
from avs.report.intervals import CONFIDENCE
from avs.report.methods import Presented, presented
from avs.report.published import headed
from avs.report.tables.significance_numbers import grid_of, ranks_of
from avs.report.tables.table_notes import count
from metrics.definitions import METRICS
from metrics.significance import AverageRanks

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WIDTH, _LINE, _HEAD = 5.2, 0.17, 0.85  # inches: of the figure, of a line of labels, of axis and title
_LETTER, _MOST_LETTERS = 0.055, 26  # inches that a letter of a label takes, and letters of the longest
_CAPTION = (
    "Average ranks of the methods that compete on {dataset}, by test PSNR at the end: ranks of each scene ({scenes}), "
    "by means over seeds ({seeds}), averaged over scenes; 1 is best. A bar lies over methods that Nemenyi's test at "
    "{level} does not tell apart: no two of them are farther apart than the critical difference, {critical:.2f}. It "
    "supposes scenes drawn independently, looks at their order alone, and is too cautious for few scenes. Friedman's "
    "test by permutation: p = {p_value:.2g}."
)
_OWN, _OTHER = "#D55E00", "#222222"  # what the paper proposes, in the colour of the other figures, and the rest


def write_critical_difference(episodes: Sequence[Path], methods: Sequence[str], dataset: str, out: Path) -> None:
    """Write ``out`` as ``.pdf`` and ``.png``, and its caption as ``.md``: the diagram of test PSNR (Demsar 2006).

    The methods that compete stand at their average ranks over scenes, seeds averaged; a bar lies over methods of which
    no two are farther apart than the critical difference. With one scene, or fewer than two methods, the figure says
    that there is none. Equal records give equal bytes.

    Args:
        episodes: ``episode.json`` files of the data set.
        methods: identifiers of the methods.
        dataset: name of the data set.
        out: path of the figure without suffix.

    Raises:
        UserError: no episodes; or a record is missing, damaged, of another data set or not comparable with the others.
    """
    collected = read_dataset(episodes, methods, dataset)
    shown = [each for method in methods if (each := presented(method, collected)).ranked]
    grid = grid_of(collected, [each.identifier for each in shown], METRICS["psnr"])
    ranks = ranks_of(grid, METRICS["psnr"])
    if ranks is None or ranks.blocks < 2:
        draw_notice(f"{headed(dataset)}: ranks need two methods and two scenes to be compared over.", out)
        return
    scenes, seeds = ", ".join(collected.scenes), ", ".join(map(str, collected.seeds))
    told = {"dataset": headed(dataset), "scenes": scenes, "seeds": seeds, "level": f"{1 - CONFIDENCE:.0%}"}
    caption = _CAPTION.format(**told, critical=ranks.critical, p_value=ranks.p_value)
    write_caption(out, caption + told_of_machines(collected.records))
    _draw(collected, [each for each in shown if each.identifier in grid], ranks, out)


def unseparated(ranks: Sequence[float], critical: float) -> list[tuple[float, float]]:
    """Return the ends of the bars: of the longest runs of ranks that are nearer to one another than ``critical``.

    Args:
        ranks: average ranks, in any order.
        critical: the critical difference.
    """
    ordered = sorted(ranks)
    runs = [(low, max(high for high in ordered if high - low < critical)) for low in ordered]
    longest = [run for run in dict.fromkeys(runs) if run[1] > run[0]]
    return [
        run
        for run in longest
        if not any(low <= run[0] and run[1] <= high for low, high in longest if (low, high) != run)
    ]


def _draw(episodes: Episodes, methods: Sequence[Presented], ranks: AverageRanks, out: Path) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    ordered = sorted(zip(ranks.ranks, methods, strict=True), key=lambda each: (each[0], each[1].label))
    bars = unseparated(ranks.ranks, ranks.critical)
    half = (len(ordered) + 1) // 2
    lines = len(bars) + half
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(_WIDTH, _HEAD + _LINE * (lines + 1)))
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        labels = {method.identifier: shortened(one_line(method.label), _MOST_LETTERS) for _, method in ordered}
        ends = 0.2, len(ordered) + 0.8
        sides = ordered[:half], ordered[half:]
        letters = [max((len(labels[method.identifier]) for _, method in side), default=0) for side in sides]
        before, behind = (_LETTER * (each + len("  10.00")) + 0.1 for each in letters)
        inch = (ends[1] - ends[0]) / (_WIDTH - before - behind)
        axes.set_xlim(ends[0] - before * inch, ends[1] + behind * inch)
        axes.set_ylim(-(lines + 1.5), _HEAD / _LINE - 0.5)
        _axis(axes, len(ordered), ranks, f"{headed(episodes.dataset)}, test PSNR, {count(ranks.blocks, 'scene')}")
        for index, (low, high) in enumerate(bars):
            axes.plot([low - 0.06, high + 0.06], [-0.6 - index] * 2, color="#555555", linewidth=2.2)
        for index, (rank, method) in enumerate(ordered):
            left = index < half
            depth = len(bars) + 1.0 + (index if left else len(ordered) - 1 - index)
            end = ends[0] if left else ends[1]
            color = _OWN if method.proposed else _OTHER
            axes.plot([rank, rank, end], [0.0, -depth, -depth], color=color, linewidth=0.7)
            label = labels[method.identifier]
            text = f"{label}  {rank:.2f}" if left else f"{rank:.2f}  {label}"
            axes.text(
                end + (-0.1 if left else 0.1), -depth, text, color=color, ha="right" if left else "left", va="center"
            )
        save_figure(figure, out)


def _axis(axes: Axes, methods: int, ranks: AverageRanks, title: str) -> None:
    """Draw the axis of ranks, the length of the critical difference, and what both are."""
    axes.plot([1, methods], [0, 0], color=_OTHER, linewidth=0.9)
    for place in range(1, methods + 1):
        axes.plot([place, place], [0, 0.25], color=_OTHER, linewidth=0.7)
        axes.text(place, 0.4, str(place), ha="center", va="bottom", fontsize=7)
    middle = sum(axes.get_xlim()) / 2
    axes.text(middle, 3.2, f"{title}: average rank, 1 is best", ha="center", va="bottom")
    reach = min(ranks.critical, methods - 1.0)
    told = f"critical difference {ranks.critical:.2f} ({1 - CONFIDENCE:.0%})"
    if ranks.critical > methods - 1.0:
        told += ": more than ranks can be apart, so that no two are told apart"
    axes.plot([1, 1 + reach], [1.75, 1.75], color="#0072B2", linewidth=1.6)
    axes.text(middle, 2.0, told, ha="center", va="bottom", color="#0072B2", fontsize=7)
