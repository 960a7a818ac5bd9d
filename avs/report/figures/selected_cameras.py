"""Draws which views each method selected, in which order: cameras in space, one panel for each method."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avs.nvs.record import Episode
from avs.report.collect import Episodes, end_of_curve, image_mean, read_dataset
from avs.report.figures.captions import told_of_machines, write_caption
from avs.report.figures.figure_files import STYLE, draw_notice, save_figure
from avs.report.figures.overview import Overview, outline_depth, outlines, overview_of
from avs.report.figures.picture_grid import shortened
from avs.report.formats.plain_text import one_line
from avs.report.methods import presented
from avs.scene.cameras import FloatArray
from avs.scene.scene import Scene, read_scene
from avs.system.errors import UserError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

_COLUMNS = 4
_PANEL = 1.79  # inches
_LETTERS = 24  # of a method's label, as many as a panel is wide
_MOST_POINTS = 4000
_OUTER, _REACH = 0.1, 0.35  # share of points that may lie outside, and how far others extend the picture beyond cameras
_MARGIN = 0.08  # around the cameras, in shares of their extent in the picture
_FLATTEST, _TALLEST = 0.55, 1.3  # height of a panel in widths
_TITLE, _BELOW = 0.15, 0.4  # inches above each panel, and below all
_CANDIDATE, _INITIAL = "#B0B0B0", "#000000"
_COLOURS, _FIRST, _LAST = "viridis", 0.0, 0.93  # its lightest yellow is lost on paper
_CAPTION = (
    "Views that each method selected on {scene} of {dataset}, with seed {seed}, all seen from one place. Colours tell "
    "the order of selection; the views that every episode begins with are black, candidates that were not selected "
    "grey, test views left out. Dots are the scene's points in their colours. Numbers are the mean test PSNR at the "
    "end in dB."
)


def write_selected_cameras(
    episodes: Sequence[Path], scene_folder: Path, methods: Sequence[str], dataset: str, out: Path
) -> None:
    """Write ``out`` with the suffixes ``.pdf`` and ``.png``, and its caption as ``.md``.

    All episodes are those of the lowest seed. Equal records give equal bytes.

    Args:
        episodes: ``episode.json`` files of one data set.
        scene_folder: the scene that is shown.
        methods: identifiers of the methods, in the order of the panels.
        dataset: name of the data set.
        out: path of the figure without suffix.

    Raises:
        UserError: a record or the scene is missing, damaged, or of another version.
    """
    collected, scene = read_dataset(episodes, methods, dataset), read_scene(scene_folder)
    shown = _of_scene(collected, scene)
    if not shown:
        return draw_notice(f"{dataset}, {scene.name}: no method has selected views of this scene", out)
    labels = [presented(each.method, collected).label for each in shown]
    caption = _CAPTION.format(scene=scene.name, dataset=dataset, seed=shown[0].seed)
    write_caption(out, caption + told_of_machines(collected.records))
    _write(shown, labels, scene, out)
    return None


def _of_scene(episodes: Episodes, scene: Scene) -> list[Episode]:
    """Return the episodes on a scene with the lowest seed, by method."""
    found = [each for each in episodes.all if each.scene == scene.name]
    for each in found:
        if each.scene_hash != scene.content_hash:
            raise UserError(scene.folder, f"is not the scene of {each.method}'s episode", "run the same line again")
    return [each for each in found if each.seed == min(other.seed for other in found)]


def _write(shown: Sequence[Episode], labels: Sequence[str], scene: Scene, out: Path) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        overview = overview_of(scene.cameras[scene.pool])
        limits = _limits(scene, overview)
        columns = min(_COLUMNS, max(2, len(shown)))
        rows = -(-len(shown) // columns)
        panel = _PANEL * float(np.divide(*(limits[1] - limits[0])[::-1]))
        size = (columns * _PANEL, rows * (panel + _TITLE) + _BELOW)
        figure = Figure(figsize=size)
        for place, episode in enumerate(shown):
            row, column = divmod(place, columns)
            bottom = size[1] - (row + 1) * (panel + _TITLE)
            box = (column * _PANEL / size[0], bottom / size[1], (_PANEL - 0.06) / size[0], panel / size[1])
            _draw(figure.add_axes(box), episode, labels[place], scene, overview, limits)
        _legend(figure, max(len(each.selected) for each in shown))
        save_figure(figure, out)


def _limits(scene: Scene, overview: Overview) -> FloatArray:
    """Return the lower left and upper right corner of the panels, ``[2, 2]``: around all cameras and what they look at.

    Of the scene's points most are taken in, as far as the cameras still fill a good part of the picture. Cameras in a
    row leave room above and below.
    """
    cameras = scene.cameras[scene.pool]
    places = overview.flattened(outlines(cameras, outline_depth(cameras, overview))).reshape(-1, 2)
    low, high = places.min(axis=0), places.max(axis=0)
    if len(scene.points):
        most = np.quantile(overview.flattened(scene.points.positions), [_OUTER, 1 - _OUTER], axis=0)
        reach = _REACH * float(np.linalg.norm(high - low))
        low, high = (
            np.minimum(low, np.maximum(most[0], low - reach)),
            np.maximum(high, np.minimum(most[1], high + reach)),
        )
    width, height = high - low + 2 * _MARGIN * float(np.linalg.norm(high - low))
    width, height = max(width, height / _TALLEST), max(height, width * _FLATTEST)
    half = np.array([width, height]) / 2
    return np.stack([(low + high) / 2 - half, (low + high) / 2 + half])


def _draw(axes: Axes, episode: Episode, label: str, scene: Scene, overview: Overview, limits: FloatArray) -> None:
    """Draw the panel of one method."""
    import matplotlib as mpl
    from matplotlib.collections import LineCollection, PolyCollection

    _draw_points(axes, scene, overview, limits)
    pool = scene.cameras[scene.pool]
    flat = overview.flattened(outlines(pool, outline_depth(pool, overview)))
    row_of = {scene.names[index]: row for row, index in enumerate(scene.pool)}
    colours = dict.fromkeys(episode.initial, mpl.colors.to_rgba(_INITIAL))
    scale = mpl.colormaps[_COLOURS]
    colours |= {name: _colour(scale, place, len(episode.selected)) for place, name in enumerate(episode.selected)}
    others = [row for name, row in row_of.items() if name not in colours]
    axes.add_collection(LineCollection(list(_edges(flat[others])), colors=_CANDIDATE, linewidths=0.35))
    rows = [row_of[name] for name in colours]
    edge = list(colours.values())
    axes.add_collection(LineCollection(list(_edges(flat[rows])), colors=np.repeat(edge, 5, axis=0), linewidths=0.7))
    axes.add_collection(PolyCollection(list(flat[rows][:, 1:]), facecolors=edge, alpha=0.55, linewidths=0))
    axes.set(xlim=limits[:, 0], ylim=limits[:, 1], aspect="equal")
    axes.set_axis_off()
    psnr = image_mean(end_of_curve(episode), "psnr")
    title = f"{shortened(one_line(label), _LETTERS)}: {psnr:.2f}"
    axes.set_title(title, loc="left", fontsize=6.5, pad=2, x=0.02)


def _draw_points(axes: Axes, scene: Scene, overview: Overview, limits: FloatArray) -> None:
    places = overview.flattened(scene.points.positions)
    inside = np.flatnonzero(((places > limits[0]) & (places < limits[1])).all(axis=1))
    kept = inside[:: max(1, len(inside) // _MOST_POINTS)]
    colours = scene.points.colors[kept] / 255.0
    x, y = places[kept].T
    axes.scatter(x, y, s=0.8, c=colours, alpha=0.35, linewidths=0, rasterized=True, zorder=0)


def _edges(flat: FloatArray) -> FloatArray:
    """Return the lines of outlines ``[n, 5, 2]``, ``[5 n, points, 2]``: of each the picture's frame, and its rays."""
    frames = flat[:, [1, 2, 3, 4, 1]]
    rays = [flat[:, [0, corner, corner, corner, corner]] for corner in (1, 2, 3, 4)]
    return np.stack([frames, *rays], axis=1).reshape(-1, 5, 2)


def _colour(scale: Colormap, place: int, count: int) -> tuple[float, float, float, float]:
    return scale(_FIRST + (_LAST - _FIRST) * place / max(1, count - 1))


def _legend(figure: Figure, count: int) -> None:
    """Say below the panels what the colours mean."""
    import matplotlib as mpl
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.lines import Line2D

    width, height = figure.get_size_inches()
    scale = mpl.colormaps[_COLOURS]
    colours = ListedColormap([_colour(scale, place, count) for place in range(count)])
    mappable = ScalarMappable(BoundaryNorm(np.arange(count + 1) + 0.5, count), colours)
    box = (0.5, 0.27 / height, min(0.46, 3.0 / width), 0.06 / height)
    bar = figure.colorbar(mappable, cax=figure.add_axes(box), orientation="horizontal")
    bar.set_ticks(list(range(1, count + 1, max(1, -(-count // 8)))))
    bar.ax.tick_params(labelsize=6, length=2, pad=1)
    bar.ax.grid(False)
    bar.minorticks_off()
    bar.set_label("order of selection", fontsize=6.5, labelpad=1)
    kinds = (("at the start", _INITIAL, 1.2), ("candidate, not selected", _CANDIDATE, 0.7))
    handles = [Line2D([], [], color=colour, linewidth=wide, label=label) for label, colour, wide in kinds]
    figure.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 0.0), fontsize=6.5, labelspacing=0.3)
