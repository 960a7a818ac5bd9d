"""Grids of pictures: columns with headings, rows of any heights, each picture in a box of its own."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from avs.report.figures.figure_files import Box, axes_in
from avs.report.formats.plain_text import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH = 7.16
"""Inches of a figure of two columns."""

GAP = 0.04
"""Inches between pictures."""

_NARROWEST = 0.9  # inches of a column: with many columns the figure becomes wider than a page
_WIDEST = 1.8  # with few it becomes narrower
_TALLEST = 1.5  # height of a picture in widths of its column: a portrait picture becomes narrower
_MARGIN = 0.25  # inches at the left, for what the rows are called, in two lines
_LINE, _LETTER = 0.105, 0.056  # inches of a line of a heading, and of a letter
_GREY = "#EEEEEE"

Pixels = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Columns:
    """Where the columns of a grid lie.

    Attributes:
        width: inches of one column.
        total: inches of the figure.
        headings: their lines of text.
    """

    width: float
    total: float
    headings: tuple[tuple[str, ...], ...]

    @property
    def top(self) -> float:
        """Inches above the first row."""
        return max((len(lines) for lines in self.headings), default=0) * _LINE + 0.05

    def left(self, column: int) -> float:
        """Return where a column begins, in inches from the left."""
        return _MARGIN + column * (self.width + GAP)


def columns_for(headings: Sequence[str]) -> Columns:
    """Return columns with these headings, as wide as a page allows; headings that are too long take several lines."""
    count = max(1, len(headings))
    width = min(max(_NARROWEST, (WIDTH - _MARGIN - GAP * (count - 1)) / count), _WIDEST)
    letters = max(1, int(width / _LETTER))
    lines = tuple(tuple(textwrap.wrap(one_line(heading), letters)) for heading in headings)
    return Columns(width, _MARGIN + count * (width + GAP) - GAP, lines)


def picture_size(columns: Columns, shape: tuple[int, ...]) -> tuple[float, float]:
    """Return the width and height in inches that a picture ``[height, width, ...]`` has in its column."""
    aspect = shape[0] / shape[1]
    height = min(columns.width * aspect, columns.width * _TALLEST)
    return height / aspect, height


def write_headings(figure: Figure, columns: Columns) -> None:
    """Write the headings, each over its column, their last lines in one line."""
    width, height = figure.get_size_inches()
    for column, lines in enumerate(columns.headings):
        place = ((columns.left(column) + columns.width / 2) / width, 1 - (columns.top - 0.03) / height)
        figure.text(*place, "\n".join(lines), ha="center", va="bottom", fontsize=6.5, linespacing=1.1)


def scene_name(dataset: str, scene: str) -> str:
    """Return what a row of a scene is called; the name of the data set is left out where the scene's begins with it."""
    return scene if scene.startswith(dataset) else f"{dataset}\n{scene}"


def write_row_name(figure: Figure, name: str, top: float, height: float) -> None:
    """Write what a row is called at its left, from ``top`` inches below the upper edge on, ``height`` inches long.

    Args:
        figure: of any size.
        name: at most two lines; what is too long is cut in its middle.
        top: inches.
        height: inches.
    """
    width, total = figure.get_size_inches()
    letters = max(8, int(height / _LETTER))
    lines = "\n".join(shortened(one_line(line), letters) for line in name.split("\n"))
    place = ((_MARGIN - 0.05) / 2 / width, 1 - (top + height / 2) / total)
    figure.text(*place, lines, ha="center", va="center", rotation=90, fontsize=6.5, linespacing=1.1)


def show(figure: Figure, pixels: Pixels, box: Box, colours: str | None = None, magnified: bool = False) -> Axes:
    """Show a picture.

    Args:
        figure: of any size.
        pixels: ``[height, width, 3]``, or a map ``[height, width]``.
        box: where.
        colours: name of the map of colours that 0..255 of a map are shown in.
        magnified: whether pixels are to be seen as squares.
    """
    axes = _bare_axes(figure, box)
    interpolation = "nearest" if magnified else "antialiased"
    axes.imshow(pixels, colours, aspect="auto", interpolation=interpolation, vmin=0, vmax=255)
    return axes


def show_gap(figure: Figure, text: str, box: Box) -> None:
    """Say in a grey box why there is no picture."""
    axes = _bare_axes(figure, box)
    axes.set_facecolor(_GREY)
    axes.patch.set_visible(True)
    lines = textwrap.fill(one_line(text), max(6, int(box[2] / _LETTER) - 1))
    axes.text(0.5, 0.5, lines, ha="center", va="center", fontsize=6, transform=axes.transAxes)


def write_on(axes: Axes, text: str, bold: bool = False) -> None:
    """Write into the lower left corner of a picture, readable on any ground."""
    axes.text(
        *(0.02, 0.03, text),
        transform=axes.transAxes,
        va="bottom",
        fontsize=6,
        fontweight="bold" if bold else "normal",
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8},
    )


def frame(axes: Axes, colour: str) -> None:
    """Draw a frame of a colour around a picture."""
    for spine in axes.spines.values():
        spine.set(visible=True, color=colour, linewidth=1.0)


def shortened(text: str, letters: int) -> str:
    """Return a text of at most so many letters; what is too long lacks its middle."""
    half = letters // 2 - 1
    return text if len(text) <= letters else f"{text[:half]}..{text[-half:]}"


def _bare_axes(figure: Figure, box: Box) -> Axes:
    axes = axes_in(figure, box)
    axes.set(xticks=[], yticks=[])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    return axes
