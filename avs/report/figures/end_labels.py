"""Names at the ends of lines, in place of a legend: none covers another, and each stays near to its line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_FONT = 5.8  # points
_DARKER = 0.75  # letters are darker than lines, which can be read at that size


@dataclass(frozen=True)
class EndLabel:
    """One name.

    Attributes:
        text: the name.
        end: x and y of the end of its line.
        colour: of the line.
        strong: whether it is emphasised.
    """

    text: str
    end: tuple[float, float]
    colour: str
    strong: bool


def label_ends(axes: Axes, labels: Sequence[EndLabel], height: float, leader: float) -> None:
    """Write names at the right of a plot, each led to by a thin line from the end of its own.

    Args:
        axes: with all limits as they stay.
        labels: the names.
        height: of a name, in shares of the plot's height.
        leader: length of the line that leads to a name, in shares of the plot's width.
    """
    from matplotlib.colors import to_rgb
    from matplotlib.lines import Line2D

    if not labels:
        return
    axes.get_xlim(), axes.get_ylim()  # which bring the limits up to date before they are used
    ends = axes.transAxes.inverted().transform(axes.transData.transform([label.end for label in labels]))
    for label, end, place in zip(labels, ends, spread(ends[:, 1], height, 0.0, 1.0), strict=True):
        axes.text(
            1.0 + leader,
            float(place),
            label.text,
            transform=axes.transAxes,
            va="center",
            fontsize=_FONT,
            fontweight="bold" if label.strong else "normal",
            color=tuple(_DARKER * part for part in to_rgb(label.colour)),
        )
        line = Line2D([end[0], 1.0 + 0.9 * leader], [end[1], place], color=label.colour, linewidth=0.4, clip_on=False)
        line.set_transform(axes.transAxes)
        axes.add_line(line)


def spread(wanted: npt.NDArray[np.float64], gap: float, low: float, high: float) -> npt.NDArray[np.float64]:
    """Return places at least ``gap`` apart whose squared distances to those wanted are least, in the same order.

    Args:
        wanted: ``[n]`` places; ties keep the order of the entries.
        gap: distance between neighbours; smaller where there is no room for it.
        low: where places begin; half a gap is left free.
        high: where they end.
    """
    count = len(wanted)
    gap = min(gap, (high - low) / max(1, count))
    order = np.argsort(wanted, kind="stable")
    steps = gap * np.arange(count)
    # With the gaps taken out, neighbours may touch but not pass: what remains is a monotone fit.
    fitted = _monotone(wanted[order] - steps)
    fitted = np.clip(fitted, low + gap / 2, high - gap / 2 - gap * (count - 1)) + steps
    places = np.empty(count)
    places[order] = fitted
    return places


def _monotone(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the ascending values nearest to these by squared distance; those in the wrong order share their mean."""
    blocks: list[tuple[float, int]] = []
    for value in values.tolist():
        mean, size = value, 1
        while blocks and blocks[-1][0] > mean:
            before, count = blocks.pop()
            mean, size = (mean * size + before * count) / (size + count), size + count
        blocks.append((mean, size))
    return np.repeat([mean for mean, _ in blocks], [size for _, size in blocks])
