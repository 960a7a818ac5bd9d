"""Draws photographs of an egocentric device beside those of a phone, and in what they differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avs.nvs.pictures import shrunk
from avs.report.figures.captions import write_caption
from avs.report.figures.figure_files import STYLE, save_figure
from avs.report.figures.image_characteristics import RINGS, Characteristics, characteristics
from avs.report.figures.picture_grid import GAP, Pixels, show
from avs.scene.even_places import evenly_spread
from avs.scene.scene import Scene, read_scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MEASURED = 40  # photographs of each kind
_ROW = 4.95  # inches, filled with as many as there is room for
_LONG_SIDE = 400  # pixels of a picture
_LEFT, _HEIGHT = 0.06, 1.2  # inches
_TITLE, _ROW_GAP = 0.17, 0.08
_PLOT, _PLOT_LEFT, _PLOT_BELOW = 1.75, 0.55, 0.4
_COLOURS = ("#D55E00", "#0072B2")
_KINDS = ("egocentric", "phone")
_CAPTION = (
    "Photographs of an egocentric device ({egocentric}) and of a phone ({phone}), spread evenly over the first scene "
    "of each data set, all at one height. The curves have the mean luminance, in linear light, by the distance to the "
    "centre of the picture, relative to the centre: what falls towards the corner is the vignette, as far as the scene "
    "is evenly bright. Field of view (horizontal x vertical), mean luminance of 0..1 and curves are means over {count} "
    "photographs of each scene, or all if there are fewer."
)


@dataclass(frozen=True)
class _Kind:
    """What is shown of one kind of photographs."""

    title: str
    photographs: tuple[Pixels, ...]
    measured: Characteristics


def write_egocentric_and_phone(egocentric: Path, phone: Path, out: Path) -> None:
    """Write ``out`` with the suffixes ``.pdf`` and ``.png``, and its caption as ``.md``.

    Args:
        egocentric: folder of a scene.
        phone: folder of another one.
        out: path of the figure without suffix.

    Raises:
        UserError: a scene or one of its photographs is missing or damaged.
    """
    scenes = [read_scene(folder) for folder in (egocentric, phone)]
    kinds = [_kind(name, scene) for name, scene in zip(_KINDS, scenes, strict=True)]
    names = {name: f"{scene.dataset}, {scene.name}" for name, scene in zip(_KINDS, scenes, strict=True)}
    write_caption(out, _CAPTION.format(**names, count=_MEASURED))
    _write(kinds, out)


def _kind(name: str, scene: Scene) -> _Kind:
    measured = evenly_spread(len(scene.names), _MEASURED)
    views = scene.views(np.array(measured))
    found = characteristics(views.cameras, views.images)
    widest = _HEIGHT * max(image.shape[1] / image.shape[0] for image in views.images)
    room = max(1, int((_ROW + GAP) / (widest + GAP)))
    shown = [measured[row] for row in evenly_spread(len(measured), room)]
    across, up = found.field_of_view
    title = f"{name}: field of view {across:.0f}° x {up:.0f}°, mean luminance {found.luminance:.2f}"
    by_row = dict(zip(measured, views.images, strict=True))
    return _Kind(title, tuple(shrunk(by_row[row], _LONG_SIDE) for row in shown), found)


def _widths(kind: _Kind) -> list[float]:
    return [_HEIGHT * picture.shape[1] / picture.shape[0] for picture in kind.photographs]


def _write(kinds: Sequence[_Kind], out: Path) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        pictures = _LEFT + max(sum(_widths(kind)) + GAP * (len(kind.photographs) - 1) for kind in kinds)
        row = _TITLE + _HEIGHT + _ROW_GAP
        figure = Figure(figsize=(pictures + _PLOT_LEFT + _PLOT + 0.08, len(kinds) * row))
        for place, kind in enumerate(kinds):
            _draw_row(figure, kind, place * row)
        _draw_curves(figure, kinds, pictures + _PLOT_LEFT)
        save_figure(figure, out)


def _draw_row(figure: Figure, kind: _Kind, top: float) -> None:
    width, height = figure.get_size_inches()
    figure.text(_LEFT / width, 1 - (top + _TITLE - 0.04) / height, kind.title, fontsize=7, va="bottom")
    left = _LEFT
    for picture, wide in zip(kind.photographs, _widths(kind), strict=True):
        show(figure, picture, (left, top + _TITLE, wide, _HEIGHT))
        left += wide + GAP


def _draw_curves(figure: Figure, kinds: Sequence[_Kind], left: float) -> None:
    width, height = figure.get_size_inches()
    box = (left / width, _PLOT_BELOW / height, _PLOT / width, 1 - (_PLOT_BELOW + _TITLE) / height)
    axes = figure.add_axes(box)
    distance = (np.arange(RINGS) + 0.5) / RINGS
    for name, kind, colour in zip(_KINDS, kinds, _COLOURS, strict=True):
        rings = kind.measured.rings
        axes.plot(distance, rings / max(float(rings[0]), 1e-6), color=colour, linewidth=1.5, label=name)
    axes.axhline(1.0, color="#999999", linewidth=0.6, zorder=1)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("distance to the centre (corner = 1)", fontsize=7, labelpad=1)
    axes.set_ylabel("luminance relative to the centre", fontsize=7, labelpad=2)
    axes.tick_params(labelsize=6.5, pad=2)
    axes.legend(fontsize=6.5, loc="best")
