"""The legend at the foot of figures of methods: what colours mean."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from avs.report.figures.curves import Curve
from avs.report.figures.method_lines import legend_styles

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ENTRY = 1.1  # inches of one entry


def write_group_legend(figure: Figure, curves: Sequence[Curve], end: str | None = None, **options: Any) -> None:  # noqa: ANN401
    """Write a line for each group that occurs, and what the dot at the end of a line means.

    Args:
        figure: of any size.
        curves: all that are drawn.
        end: the meaning of the dot; None where it has no entry.
        options: of ``Figure.legend``, beside those of the house.
    """
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], label=name, **style) for name, style in legend_styles(curves).items()]
    if end is not None:
        handles.append(Line2D([], [], marker="o", color="#555555", markersize=2.5, linestyle="", label=end))
    figure.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, 0.0),
        ncols=min(max(1, int(figure.get_figwidth() / _ENTRY)), len(handles)),
        fontsize=5.8,
        handlelength=1.4,
        columnspacing=0.8,
        labelspacing=0.25,
        **options,
    )
