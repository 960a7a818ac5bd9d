"""Draws the time of each selection in an episode, and the test PSNR, over the number of captured views."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avs.nvs.record import Episode, EpisodeMeta
from avs.report.collect import Cell, Episodes, read_dataset
from avs.report.figures.captions import told_of_machines, write_caption
from avs.report.figures.curves import Curve, panels
from avs.report.figures.end_labels import EndLabel, label_ends
from avs.report.figures.figure_files import STYLE, axes_in, draw_notice, save_figure
from avs.report.figures.group_legend import write_group_legend
from avs.report.figures.method_lines import emphasised, line_styles
from avs.report.figures.picture_grid import shortened
from avs.report.formats.plain_text import one_line
from avs.system.records import read_record

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LEFT, _GAP, _LETTER, _LEADER = 0.56, 0.62, 0.05, 0.14  # inches
_PLOT, _LEAST, _LABEL = 1.95, 1.9, 0.098  # inches: width of a plot, its least height, and the height of a name
_ABOVE, _BELOW = 0.2, 0.62  # inches
_MOST_LETTERS = 24
_CAPTION = (
    "Time of each selection (left) and test PSNR (right) over the number of captured views on {scene} of {dataset}, "
    "mean over {seeds}. The time axis is linear up to {threshold:g} s and logarithmic above. Times are those within "
    "the episodes, while other jobs of the run could be busy. A method that chooses several views at a time has a "
    "point where it chooses, one that chooses outside of its episodes none. "
    "Thick lines are the reference method and the two with the highest PSNR; a dot is the end of the optimisation."
)

Line = tuple[list[int], list[float]]
"""Numbers of captured views, and seconds."""


def write_time_and_psnr(
    episodes: Sequence[Path], methods: Sequence[str], dataset: str, reference: str | None, out: Path
) -> None:
    """Write ``out`` with the suffixes ``.pdf`` and ``.png``, and its caption as ``.md``.

    Args:
        episodes: ``episode.json`` files on one scene, with ``episode.meta.json`` beside them.
        methods: identifiers of the methods, in order.
        dataset: name of the data set.
        reference: the method that the tables compare with, or None.
        out: path of the figure without suffix.

    Raises:
        UserError: a record is missing, damaged, or not comparable with the others.
    """
    collected = read_dataset(episodes, methods, dataset)
    (panel,) = panels(collected) or (None,)
    if panel is None:
        return draw_notice(f"{dataset}: the methods share no scene and seed.", out)
    shared = sorted(set.intersection(*(set(cells) for cells in collected.cells.values())))
    times = {curve.method: selection_times(collected, curve.method, shared) for curve in panel.curves}
    threshold = linear_up_to([value for _, values in times.values() for value in values])
    scenes, seeds = sorted({scene for scene, _ in shared}), {seed for _, seed in shared}
    told = f"{len(seeds)} seeds" if len(seeds) > 1 else "one seed"
    caption = _CAPTION.format(scene=", ".join(scenes), dataset=dataset, seeds=told, threshold=threshold)
    write_caption(out, caption + told_of_machines(collected.records, timed=True))
    _write(panel.curves, times, threshold, panel.title, reference, out)
    return None


def selection_times(episodes: Episodes, method: str, cells: Sequence[Cell]) -> Line:
    """Return by number of captured views the seconds of the selection that was made then, as a mean over episodes."""
    found: dict[int, list[float]] = {}
    for scene, seed in cells:
        episode = episodes.cells[method][scene, seed]
        path = episodes.places[method, scene, seed].with_name("episode.meta.json")
        for views, seconds in _by_views(episode, read_record(path, EpisodeMeta)).items():
            found.setdefault(views, []).append(seconds)
    numbers = sorted(found)
    return numbers, [float(np.mean(found[number])) for number in numbers]


def linear_up_to(seconds: Sequence[float]) -> float:
    """Return the power of ten up to which the time axis is linear, half a decade or more below the longest times.

    With the paper's, 20 s, that is 1 s, as in its figure. One selection in ten may take longer: the first, in which a
    method may have to load its libraries, says nothing of the others.
    """
    long = float(np.quantile(seconds, 0.9)) if seconds else 1.0
    return float(10.0 ** np.floor(np.log10(max(long, 1e-6)) - 0.5))


def _by_views(episode: Episode, meta: EpisodeMeta) -> Mapping[int, float]:
    """Return the seconds of each selection by the number of views that were captured before it.

    A selection without scores took what was chosen elsewhere: its time says nothing.
    """
    before = np.cumsum([len(episode.initial), *(len(step.chosen) for step in episode.steps)])
    steps = zip(before.tolist(), episode.steps, meta.steps, strict=False)
    return {views: times.total_seconds for views, step, times in steps if step.scores is not None}


def _write(
    curves: Sequence[Curve],
    times: Mapping[str, Line],
    threshold: float,
    title: str,
    reference: str | None,
    out: Path,
) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        names = {curve.method: shortened(one_line(curve.label), _MOST_LETTERS) for curve in curves}
        labels = _LEADER + 0.04 + max(map(len, names.values())) * _LETTER
        height = max(_LEAST, _LABEL * len(curves))
        width = _LEFT + 2 * (_PLOT + labels) + _GAP
        figure = Figure(figsize=(width, _ABOVE + height + _BELOW))
        lefts = (_LEFT, _LEFT + _PLOT + labels + _GAP)
        left, right = (axes_in(figure, (start, _ABOVE, _PLOT, height)) for start in lefts)
        left.set_title(title, loc="left", fontsize=7.5, pad=3)
        styles, strong = line_styles(curves, reference), emphasised(curves, reference)
        for curve in curves:
            left.plot(*times[curve.method], **styles[curve.method])
            right.plot(curve.views, curve.mean, **styles[curve.method])
            end = {"color": styles[curve.method]["color"], "zorder": styles[curve.method]["zorder"], "markersize": 2.5}
            right.plot(curve.views[-1:], curve.mean[-1:], "o", clip_on=False, **end)
        _dress(left, right, threshold, max((max(values, default=0.0) for _, values in times.values()), default=1.0))
        for axes, lines in ((left, times), (right, {each.method: (each.views, each.mean) for each in curves})):
            ends = [
                EndLabel(
                    names[method], (float(views[-1]), float(values[-1])), styles[method]["color"], method in strong
                )
                for method, (views, values) in lines.items()
                if len(views)
            ]
            label_ends(axes, ends, _LABEL / height, _LEADER / _PLOT)
        write_group_legend(figure, curves)
        save_figure(figure, out)


def _dress(left: Axes, right: Axes, threshold: float, longest: float) -> None:
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    decades = max(0.5, float(np.log10(max(longest, threshold) / threshold)))
    left.set_yscale("symlog", linthresh=threshold, linscale=decades)  # the linear part is as high as the other
    left.set_ylim(0.0, 1.15 * max(longest, threshold))
    steps = [threshold * share for share in (0.0, 0.25, 0.5, 0.75)]
    powers = [threshold * factor * 10**power for power in range(4) for factor in (1, 2, 5)]
    left.set_yticks([*steps, *(value for value in powers if value <= 1.15 * longest)])
    left.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.3g}"))
    left.minorticks_off()
    left.axhline(threshold, color="#999999", linewidth=0.6, zorder=1)
    left.sharex(right)
    for axes, text in ((left, "time of one selection (s)"), (right, "test PSNR (dB)")):
        axes.set_ylabel(text, fontsize=7, labelpad=2)
        axes.set_xlabel("captured views", fontsize=7, labelpad=1)
        axes.tick_params(labelsize=6.5, pad=2)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 4, 5, 10]))
