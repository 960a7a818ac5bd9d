"""The house's style of figures, and how one becomes files: equal figures are equal bytes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from avs.report.figures.captions import write_caption
from avs.system.files import atomic_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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


Box = tuple[float, float, float, float]
"""Inches from the left, inches from the upper edge, width and height in inches."""


def axes_in(figure: Figure, box: Box) -> Axes:
    """Return new axes of a figure, which lie in a box."""
    width, height = figure.get_size_inches()
    left, top, wide, high = box
    return figure.add_axes((left / width, 1 - (top + high) / height, wide / width, high / height))


def draw_notice(text: str, out: Path) -> None:
    """Write a figure that says why there is nothing to draw, in place of one, and the same as its caption."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.0, 1.0))
        figure.text(0.02, 0.5, text, va="center", wrap=True)
        save_figure(figure, out)
    write_caption(out, text)


def save_figure(figure: Figure, out: Path) -> None:
    """Write a figure to ``out`` with the suffixes ``.pdf`` and ``.png``; equal figures give equal bytes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    for suffix, metadata in _METADATA.items():
        with atomic_path(out.with_name(out.name + suffix)) as temporary:
            figure.savefig(temporary, format=suffix[1:], metadata=dict(metadata))
