"""Draws selection time against test PSNR: what a method costs, and what it brings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avs.nvs.timing_record import Runtime
from avs.report.collect import Episodes
from avs.report.figures.captions import sentences, told_of_machines, write_caption
from avs.report.figures.figure_files import STYLE, draw_notice, save_figure
from avs.report.figures.method_lines import called, group_colours
from avs.report.figures.picture_grid import shortened
from avs.report.figures.point_labels import FloatArray, placed
from avs.report.formats.plain_text import one_line
from avs.report.methods import presented
from avs.report.tables.selection_times_numbers import read_runtimes, summarise_runtime
from avs.report.tables.timing_words import comparable, episodes_of_scene, load_notes
from avs.selection.contract import UNRANKED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WIDTH, _HEIGHT = 3.5, 2.9  # inches
_LEFT, _BELOW = 0.48, 0.62
_PLOT = (_WIDTH - _LEFT - 0.08, _HEIGHT - _BELOW - 0.2)
_LETTER, _LINE, _MOST_LETTERS, _FONT = 0.052, 0.1, 24, 6.0
_FRONT, _THIN = "#BBBBBB", 0.01  # its colour, and inches beside it that names leave free
_FAR = 0.16  # inches from its point at which a line leads to a name
_NOTHING = "No method has both a selection time and an episode on the scene on which selections are timed."
_CAPTION = (
    "Time of one selection ({candidates} candidates, {captured} captured views, {gaussians} Gaussians, {device}, the "
    "median of those timed, logarithmic axis) against the mean test PSNR at the end on {scene} of {dataset}, mean over "
    "{seeds}. {front}Oracles and methods of another schedule are grey squares. {joint}"
)
_WITH_FRONT = (
    "The grey line is the Pareto front of the methods that compete: none of them is both faster and better than one on "
    "it. "
)


@dataclass(frozen=True)
class Point:
    """One method: its printed name, what its group is called, seconds of one selection, and PSNR in dB.

    A method that lacks an episode that others have is not ``whole``: its PSNR has no place among the others'.
    """

    method: str
    label: str
    group: str
    seconds: float
    psnr: float
    whole: bool = True

    @property
    def competes(self) -> bool:
        """Whether it is one of the methods that are compared."""
        return self.group not in UNRANKED


def write_teaser(records: Sequence[Path], episodes: Sequence[Path], methods: Sequence[str], out: Path) -> None:
    """Write ``out`` with the suffixes ``.pdf`` and ``.png``, and its caption as ``.md``.

    Args:
        records: of the timing, one a method.
        episodes: ``episode.json`` files on the scene of the timing.
        methods: identifiers of the methods, in order.
        out: path of the figure without suffix.

    Raises:
        UserError: a record is missing, damaged, or not comparable with the others.
    """
    times = read_runtimes(records)
    collected = episodes_of_scene(episodes, methods, times)
    points = points_of(times, collected, methods)
    if not points:
        return draw_notice(_NOTHING, out)
    shown = [times[point.method] for point in points]
    front = pareto_front([point for point in points if point.competes and point.whole]) if comparable(shown) else []
    told = sentences(load_notes(shown)) + told_of_machines(collected.records)
    write_caption(out, _caption(times, collected, points, front) + told)
    _write(points, front, f"{collected.dataset}: {next(iter(times.values())).scene}", out)
    return None


def points_of(times: dict[str, Runtime], episodes: Episodes, methods: Sequence[str]) -> list[Point]:
    """Return the methods that have a time and a PSNR; both as the table of selection times has them."""
    points = []
    for method, row in summarise_runtime(times, episodes, methods, {}).items():
        seconds, psnr = row["selection_seconds"].value, row["psnr"].value
        if seconds is not None and psnr is not None:
            shown = presented(method, episodes)
            points.append(Point(method, shown.label, shown.group, seconds, psnr, shown.whole))
    return points


def pareto_front(points: Sequence[Point]) -> list[Point]:
    """Return the points to which no other is both at least as fast and better, from fast to slow."""
    front: list[Point] = []
    for point in sorted(points, key=lambda each: (each.seconds, -each.psnr)):
        if not front or point.psnr > front[-1].psnr:
            front.append(point)
    return front


def _caption(times: dict[str, Runtime], episodes: Episodes, points: Sequence[Point], front: Sequence[Point]) -> str:
    first = times[points[0].method]
    joint = [f"{point.label} chooses {times[point.method].chosen} views at a time" for point in points]
    told = [text for text, point in zip(joint, points, strict=True) if times[point.method].chosen > 1]
    seeds = len(episodes.seeds)
    return _CAPTION.format(
        candidates=first.candidates,
        captured=first.captured,
        gaussians=first.primitives,
        device={"cpu": "on a processor", "cuda": "on a GPU"}.get(first.device, first.device),
        scene=first.scene,
        dataset=episodes.dataset,
        seeds=f"{seeds} seeds" if seeds > 1 else "one seed",
        front=_WITH_FRONT if front else "",
        joint="; ".join(told) + "." if told else "",
    ).strip()


def _write(points: Sequence[Point], front: Sequence[Point], title: str, out: Path) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(_WIDTH, _HEIGHT))
        box = (_LEFT / _WIDTH, _BELOW / _HEIGHT, _PLOT[0] / _WIDTH, _PLOT[1] / _HEIGHT)
        axes = figure.add_axes(box)
        axes.set_title(title, loc="left", fontsize=7.5, pad=3)
        colours = group_colours(called(point.method, point.group) for point in points)
        _dress(axes, points)
        axes.step(*_stairs(front, axes.get_xlim()[1]), where="post", color=_FRONT, linewidth=1.2, zorder=1)
        for point in points:
            colour = colours[called(point.method, point.group)]
            axes.plot(point.seconds, point.psnr, _marker(point), color=colour, markersize=3.6, zorder=4)
        _name(axes, points, colours, front)
        _legend(axes, points, colours)
        save_figure(figure, out)


def _marker(point: Point) -> str:
    return "o" if point.competes else "s"


def _dress(axes: Axes, points: Sequence[Point]) -> None:
    from matplotlib.ticker import FuncFormatter

    axes.set_xscale("log")
    seconds, psnr = np.array([[point.seconds, point.psnr] for point in points]).T
    span = max(float(np.log10(seconds.max() / seconds.min())), 1.0)
    axes.set_xlim(seconds.min() / 10 ** (0.06 * span), seconds.max() * 10 ** (0.10 * span))
    margin = 0.07 * max(float(np.ptp(psnr)), 0.5)
    axes.set_ylim(psnr.min() - margin, psnr.max() + margin)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlabel("time of one selection (s)", fontsize=7, labelpad=1)
    axes.set_ylabel("test PSNR (dB)", fontsize=7, labelpad=2)
    axes.tick_params(labelsize=6.5, pad=2)
    axes.minorticks_off()


def _stairs(front: Sequence[Point], end: float) -> tuple[list[float], list[float]]:
    """Return the corners of the front, which goes on to the right from its last point."""
    seconds, psnr = [point.seconds for point in front], [point.psnr for point in front]
    return ([*seconds, end], [*psnr, psnr[-1]]) if front else ([], [])


def _inches(axes: Axes, places: Sequence[tuple[float, float]]) -> FloatArray:
    """Return where seconds and decibels lie in the plot, ``[n, 2]`` in inches."""
    shares = axes.transAxes.inverted().transform(axes.transData.transform(places))
    return np.asarray(shares * np.array(_PLOT))


def _front_boxes(axes: Axes, front: Sequence[Point]) -> list[FloatArray]:
    """Return thin boxes around the lines of the front, which names are not to cover."""
    if not front:
        return []
    corners = _inches(axes, list(zip(*_stairs(front, axes.get_xlim()[1]), strict=True)))
    boxes = []
    for (left, low), (right, high) in pairwise(corners):
        boxes += [[left, low - _THIN, right, low + _THIN], [right - _THIN, low, right + _THIN, high]]
    return [np.array(box) for box in boxes]


def _name(axes: Axes, points: Sequence[Point], colours: dict[str, str], front: Sequence[Point]) -> None:
    """Write the names beside the points; those on the front are bold."""
    from matplotlib.colors import to_rgb

    names = [shortened(one_line(point.label), _MOST_LETTERS) for point in points]
    letters = [_LETTER * (1.22 if point in front else 1.0) for point in points]
    sizes = np.array([[letter * len(name), _LINE] for letter, name in zip(letters, names, strict=True)])
    centres = _inches(axes, [(point.seconds, point.psnr) for point in points])
    corners = placed(centres, sizes, _PLOT, _front_boxes(axes, front))
    for point, name, corner, size, centre in zip(points, names, corners, sizes, centres, strict=True):
        colour = colours[called(point.method, point.group)]
        nearest = np.clip(centre, corner, corner + size)
        if np.linalg.norm(nearest - centre) > _FAR:
            x, y = (np.stack([centre, nearest]) / np.array(_PLOT)).T
            axes.plot(x, y, color=colour, linewidth=0.4, transform=axes.transAxes, zorder=2)
        left, bottom = (corner / np.array(_PLOT)).tolist()
        axes.text(
            left,
            bottom,
            name,
            transform=axes.transAxes,
            fontsize=_FONT,
            fontweight="bold" if point in front else "normal",
            color=tuple(0.75 * part for part in to_rgb(colour)),  # as names at the ends of lines are
            va="bottom",
        )


def _legend(axes: Axes, points: Sequence[Point], colours: dict[str, str]) -> None:
    from matplotlib.lines import Line2D

    kinds = {called(point.method, point.group): _marker(point) for point in points}
    order = [name for name in (*colours, *kinds) if name in kinds]
    shown = dict.fromkeys(sorted(dict.fromkeys(order), key=lambda name: name in UNRANKED))
    handles = [
        Line2D([], [], marker=kinds[name], color=colours[name], label=name, linestyle="", markersize=3.6)
        for name in shown
    ]
    handles.append(Line2D([], [], color=_FRONT, linewidth=1.2, label="Pareto front"))
    axes.legend(
        handles=handles,
        loc="upper center",
        bbox_to_anchor=(0.43, -0.155),
        ncols=4,
        fontsize=5.6,
        handlelength=1.0,
        columnspacing=0.7,
        labelspacing=0.2,
    )
