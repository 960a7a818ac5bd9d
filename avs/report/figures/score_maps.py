"""Draws what methods thought of the views that they chose, place by place, beside what was true of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avs.nvs.pictures import read_pictures
from avs.nvs.record import Episode
from avs.report.collect import read_dataset
from avs.report.figures.captions import told_of_machines, write_caption
from avs.report.figures.figure_files import STYLE, draw_notice, save_figure
from avs.report.figures.picture_grid import (
    GAP,
    Columns,
    Pixels,
    columns_for,
    picture_size,
    show,
    write_on,
    write_row_name,
)
from avs.report.methods import presented
from avs.scene.even_places import evenly_spread
from avs.selection import registry

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = "viridis"
_BELOW = 0.36  # inches, for the scale of colours
_METHOD_GAP = 0.1  # inches between methods
_PREDICTED, _TRUE, _RENDERING = "predicted", "true", "rendering"
_NOTHING = "No maps: no method of this data set predicts one, or its episode keeps no pictures."
_CAPTION = (
    "Views at the moments at which they were chosen on {scene} of {dataset}, with seed {seed}: the rendering, the SSIM "
    "map that the method predicts of it, and the SSIM map against the photograph, which no method but an oracle has. "
    "Moments are spread evenly over the selections; numbers on maps are means of what is shown, eight bits with SSIM "
    "below 0 as 0, so that they can be some thousandths above what was scored. SSIM is high at the border, because "
    "beyond it both images count as black."
)


@dataclass(frozen=True)
class _Moment:
    """One selection: the pictures by kind, and how many views there are once it is captured."""

    views: int
    pictures: Mapping[str, Pixels]


@dataclass(frozen=True)
class _Block:
    """One method: its printed name, the kinds of pictures that it has, and its moments."""

    label: str
    kinds: tuple[str, ...]
    moments: tuple[_Moment, ...]


def write_score_maps(
    episodes: Sequence[Path], methods: Sequence[str], moments: int, dataset: str, scene: str, out: Path
) -> None:
    """Write ``out`` with the suffixes ``.pdf`` and ``.png``, and its caption as ``.md``; equal records, equal bytes.

    A method has a place if it predicts maps, or chooses by the true one.

    Args:
        episodes: ``episode.json`` files of one data set, with their pictures beside them.
        methods: identifiers of the methods, in the order of the rows.
        moments: how many selections are shown of each.
        dataset: name of the data set.
        scene: name of the scene; the lowest seed is shown.
        out: path of the figure without suffix.

    Raises:
        UserError: a record or its pictures are missing, damaged or changed.
    """
    collected = read_dataset(episodes, methods, dataset)
    found = [each for each in collected.all if each.scene == scene]
    seed = min((each.seed for each in found), default=0)
    blocks = []
    for episode in found:
        pictures = read_pictures(collected.places[episode.method, scene, episode.seed], episode)
        kinds = _kinds(episode, pictures)
        if episode.seed == seed and kinds:
            label = presented(episode.method, collected).label
            blocks.append(_Block(label, kinds, _moments(episode, pictures, kinds, moments)))
    if not blocks:
        return draw_notice(f"{dataset}: {_NOTHING}", out)
    caption = _CAPTION.format(scene=scene, dataset=dataset, seed=seed)
    write_caption(out, caption + told_of_machines(collected.records))
    _write(blocks, out)
    return None


def _kinds(episode: Episode, pictures: Mapping[str, Pixels]) -> tuple[str, ...]:
    """Return the kinds of pictures that are shown of an episode; none if there is no map that the method went by."""
    if any(name.endswith(_PREDICTED) for name in pictures):
        return (_RENDERING, _PREDICTED, _TRUE)
    known = registry.methods().get(episode.method)
    by_truth = known is not None and known.method.measures == "ssim"
    return (_RENDERING, _TRUE) if by_truth and any(name.endswith(_TRUE) for name in pictures) else ()


def _moments(episode: Episode, pictures: Mapping[str, Pixels], kinds: Sequence[str], count: int) -> tuple[_Moment, ...]:
    """Return selections that are spread evenly over an episode, of each the view of the best score."""
    chosen = np.cumsum([0, *(len(step.chosen) for step in episode.steps)])
    return tuple(
        _Moment(
            len(episode.initial) + int(chosen[place]) + 1,
            {kind: pictures[f"choice_{episode.steps[place].step:02d}_0_{kind}"] for kind in kinds},
        )
        for place in evenly_spread(len(episode.steps), count)
    )


def _write(blocks: Sequence[_Block], out: Path) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        columns = columns_for([""] * max(len(block.moments) for block in blocks))
        heights = [_row_height(columns, block) for block in blocks]
        rows = sum(len(block.kinds) * height for block, height in zip(blocks, heights, strict=True))
        figure = Figure(figsize=(columns.total + 0.02, rows + _METHOD_GAP * (len(blocks) - 1) + _BELOW))
        top = 0.0
        for block, height in zip(blocks, heights, strict=True):
            for kind in block.kinds:
                _draw_row(figure, columns, block, kind, top)
                write_row_name(figure, f"{block.label}\n{_called(kind)}", top, height - GAP)
                top += height
            top += _METHOD_GAP
        _scale(figure)
        save_figure(figure, out)


def _row_height(columns: Columns, block: _Block) -> float:
    shapes = [moment.pictures[_RENDERING].shape for moment in block.moments]
    return max(picture_size(columns, shape)[1] for shape in shapes) + GAP


def _called(kind: str) -> str:
    return {_RENDERING: "rendering", _PREDICTED: "predicted", _TRUE: "true SSIM"}[kind]


def _draw_row(figure: Figure, columns: Columns, block: _Block, kind: str, top: float) -> None:
    for column, moment in enumerate(block.moments):
        pixels = moment.pictures[kind]
        width, height = picture_size(columns, moment.pictures[_RENDERING].shape)
        box = (columns.left(column) + (columns.width - width) / 2, top, width, height)
        if kind == _RENDERING:
            write_on(show(figure, pixels, box), f"view {moment.views}")
        else:
            write_on(show(figure, pixels, box, _COLOURS), f"{pixels.mean() / 255.0:.2f}")


def _scale(figure: Figure) -> None:
    """Draw below all what the colours of maps mean."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    width, height = figure.get_size_inches()
    long = min(2.0, width - 0.3)  # inches
    box = (0.5 - long / 2 / width, 0.24 / height, long / width, 0.06 / height)
    mappable = ScalarMappable(Normalize(0.0, 1.0), _COLOURS)
    bar = figure.colorbar(mappable, cax=figure.add_axes(box), orientation="horizontal")
    bar.ax.tick_params(labelsize=6, length=2, pad=1)
    bar.ax.grid(False)
    bar.set_label("SSIM", fontsize=6.5, labelpad=1)
