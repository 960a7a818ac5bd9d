"""Draws renderings of several methods beside the photograph: one test image of each scene, with magnified parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from avs.nvs.pictures import read_pictures, shrunk
from avs.report.collect import Episodes, read_episodes
from avs.report.figure_settings import FigureSettings
from avs.report.figures.captions import told_of_machines, write_caption
from avs.report.figures.differing_regions import Window, cut, differing_windows
from avs.report.figures.figure_files import STYLE, draw_notice, save_figure
from avs.report.figures.picture_grid import (
    GAP,
    Columns,
    Pixels,
    columns_for,
    frame,
    picture_size,
    scene_name,
    show,
    show_gap,
    write_headings,
    write_on,
    write_row_name,
)
from avs.report.figures.shown_methods import image_psnr, most_differing, shown_methods
from avs.report.methods import presented
from avs.scene.scene import read_scene
from avs.system.errors import UserError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#E69F00", "#56B4E9")  # of the magnified squares: Okabe and Ito's orange and sky blue
_ROW_GAP = 0.08  # inches
_NOTHING = "No renderings: no episode keeps any, or no method of report.figures.methods has run."
_CAPTION = (
    "Renderings of test images at the end of the optimisation, and the photographs. Each row is a scene, with seed "
    "{seeds}: of the test images whose renderings are kept, the one whose PSNR ranges most among the methods shown. "
    "The squares, the same for all methods of a row, are where their renderings vary most (variance over methods, "
    "summed over channels and pixels). Numbers are the PSNR of the image in dB, the highest of a row in bold. Methods "
    "are those of `report.figures.methods`; none was chosen by its picture."
)


@dataclass(frozen=True)
class _Row:
    """One scene.

    Attributes:
        name: data set and scene.
        seed: of the episodes.
        truth: the photograph.
        renderings: by method, with the PSNR.
    """

    name: str
    seed: int
    truth: Pixels
    renderings: Mapping[str, tuple[Pixels, float]]


def write_qualitative(
    episodes: Sequence[Path],
    scenes: Sequence[Path],
    methods: Sequence[str],
    settings: FigureSettings,
    reference: str | None,
    out: Path,
) -> None:
    """Write ``out`` with the suffixes ``.pdf`` and ``.png``, and its caption as ``.md``.

    Args:
        episodes: ``episode.json`` files of any data sets; their pictures lie beside them.
        scenes: folders of the scenes that are rows, in order, each within the folder of its data set.
        methods: identifiers of all methods of the episodes.
        settings: which of them are shown, and how many rows.
        reference: the method that the tables compare with, or None.
        out: path of the figure without suffix.

    Raises:
        UserError: a record, its pictures or a scene is missing, damaged or of another version.
    """
    collected = {each.dataset: each for each in read_episodes(episodes, methods)}
    shown = {name: shown_methods(each, settings.methods, reference) for name, each in collected.items()}
    places = [(folder.parent.name, folder.name, folder) for folder in scenes[: settings.rows]]
    read = [_read(collected[name], scene, shown[name], folder) for name, scene, folder in places if name in collected]
    rows = [row for row in read if row is not None]
    order = list(dict.fromkeys(each for found in shown.values() for each in found))
    columns = [method for method in order if any(method in row.renderings for row in rows)]
    seeds = ", ".join(map(str, sorted({row.seed for row in rows})))
    if not rows:
        return draw_notice(_NOTHING, out)
    write_caption(out, _CAPTION.format(seeds=seeds) + told_of_machines(episodes))
    labels = {method: _label(collected, method) for method in columns}
    _write(rows, labels, out)
    return None


def _label(collected: Mapping[str, Episodes], method: str) -> str:
    return next(presented(method, each).label for each in collected.values() if each.cells.get(method))


def _read(episodes: Episodes, scene: str, methods: Sequence[str], folder: Path) -> _Row | None:
    """Return the row of a scene, or None if no method keeps a rendering of it."""
    seed = min((seed for cells in episodes.cells.values() for name, seed in cells if name == scene), default=0)
    found = {method: episodes.cells[method].get((scene, seed)) for method in methods}
    kept = {method: each for method, each in found.items() if each is not None and each.pictures is not None}
    name = most_differing(list(kept.values()))
    if name is None:
        return None
    photographed = read_scene(folder)
    renderings = {}
    for method, episode in kept.items():
        if episode.scene_hash != photographed.content_hash:
            raise UserError(folder, f"is not the scene of {method}'s episode", "run the same line again")
        assert episode.pictures is not None
        pictures = read_pictures(episodes.places[method, scene, seed], episode)
        place = episode.pictures.test.index(name)
        renderings[method] = pictures[f"final_{place:03d}"], image_psnr(episode, name)
    size = max(next(iter(renderings.values()))[0].shape[:2])
    truth = shrunk(photographed.views([photographed.names.index(name)]).images[0], size)
    return _Row(scene_name(episodes.dataset, scene), seed, truth, renderings)


def _write(rows: Sequence[_Row], labels: Mapping[str, str], out: Path) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        columns = columns_for([*labels.values(), "photograph"])
        edge = (columns.width - GAP) / 2
        heights = [picture_size(columns, row.truth.shape)[1] + GAP + edge + _ROW_GAP for row in rows]
        figure = Figure(figsize=(columns.total + 0.02, columns.top + sum(heights)))
        write_headings(figure, columns)
        top = columns.top
        for row, height in zip(rows, heights, strict=True):
            _draw_row(figure, columns, row, list(labels), top)
            write_row_name(figure, row.name, top, height - _ROW_GAP)
            top += height
        save_figure(figure, out)


def _draw_row(figure: Figure, columns: Columns, row: _Row, methods: Sequence[str], top: float) -> None:
    windows = differing_windows([pixels for pixels, _ in row.renderings.values()], row.truth, len(_COLOURS))
    best = max(psnr for _, psnr in row.renderings.values())
    height = picture_size(columns, row.truth.shape)[1]
    for column, method in enumerate(methods):
        if method not in row.renderings:
            show_gap(figure, "no episode", (columns.left(column), top, columns.width, height))
            continue
        pixels, psnr = row.renderings[method]
        axes = _draw_cell(figure, columns, column, pixels, windows, top)
        write_on(axes, f"{psnr:.2f}", bold=f"{psnr:.2f}" == f"{best:.2f}")
    _draw_cell(figure, columns, len(methods), row.truth, windows, top)


def _draw_cell(
    figure: Figure, columns: Columns, column: int, pixels: Pixels, windows: Sequence[Window], top: float
) -> Axes:
    """Draw one picture with its magnified parts, and return the axes of the whole one."""
    from matplotlib.patches import Rectangle

    width, height = picture_size(columns, pixels.shape)
    axes = show(figure, pixels, (columns.left(column) + (columns.width - width) / 2, top, width, height))
    edge = (columns.width - GAP) / 2
    for place, (window, colour) in enumerate(zip(windows, _COLOURS, strict=False)):
        left = columns.left(column) + place * (edge + GAP)
        axes.add_patch(Rectangle(window[:2], window[2], window[2], fill=False, edgecolor=colour, linewidth=0.8))
        part = show(figure, cut(pixels, window), (left, top + height + GAP, edge, edge), magnified=True)
        frame(part, colour)
    return axes
