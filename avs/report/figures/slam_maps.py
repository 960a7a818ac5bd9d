"""Draws explorations seen from above: the truth, what was covered, the way, frontiers, and choices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from avs.report.collect_explorations import check_comparable, printed_name, read_maps
from avs.report.figures.figure_files import STYLE, save_figure
from avs.report.formats.plain_text import one_line
from avs.slam.evaluation.top_view import CEILING, CELL
from avs.slam.loop.exploration_record import ExplorationRecord
from avs.system.errors import UserError
from avs.system.records import read_record

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

_COLUMN = 0.05  # metres of a pixel of a map
_COLUMNS = 3
_PANEL_WIDTH = 2.9  # inches
_COVERED = "RdYlBu"
_FAINT = 0.35
_FRONTIER = "#009E73"


@dataclass(frozen=True)
class _Explored:
    """A record with the arrays of ``exploration_record.MAPS``."""

    record: ExplorationRecord
    arrays: dict[str, npt.NDArray[Any]]


def write_slam_maps(records: Sequence[Path], maps: Sequence[Path], out: Path) -> None:
    """Write ``out`` with the suffixes ``.pdf`` and ``.png``: a map for each exploration, all of one building and start.

    The first map is the truth, from above and without what lies higher than 1.8 m. Another shows the share of each
    column of the surface below that height which lies within the threshold of a Gaussian's centre, from red (none) to
    blue (all); the way of the robot, from dark to bright; frontiers that were left; and the candidates that were
    chosen, and those that were not.
    Equal records give equal bytes.

    Args:
        records: ``exploration.json`` of each.
        maps: their ``maps.safetensors``, in the same order.
        out: path of the figure without suffix.

    Raises:
        UserError: no record; or one is missing, damaged, of another building or start, or not comparable.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    explored = [_read(path, arrays) for path, arrays in zip(records, maps, strict=True)]
    if not explored:
        raise UserError("maps of explorations", "no record", "pass at least one exploration.json")
    check_comparable({path: one.record for path, one in zip(records, explored, strict=True)})
    for path, one in zip(records, explored, strict=True):
        if (one.record.building, one.record.seed) != (explored[0].record.building, explored[0].record.seed):
            raise UserError(path, "is of another building or seed than others", "draw those of one together")
    low, high = _box(explored)
    with mpl.rc_context(STYLE):
        columns = min(len(explored) + 1, _COLUMNS)
        rows = -(-(len(explored) + 1) // columns)
        height = _PANEL_WIDTH * float((high - low)[1] / (high - low)[0])
        figure = Figure(figsize=(columns * _PANEL_WIDTH, rows * (height + 0.35) + 0.55), layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        _draw_truth(axes[0], explored[0], low, high)
        for place, one in zip(axes[1:], explored, strict=False):
            _draw(place, one, printed_name(one.record.method, (each.record for each in explored)), low, high)
        for place in axes[len(explored) + 1 :]:
            place.remove()
        figure.legend(handles=_legend(), loc="outside lower center", ncols=6)
        save_figure(figure, out)


def _read(path: Path, arrays: Path) -> _Explored:
    return _Explored(read_record(path, ExplorationRecord), read_maps(arrays))


def _box(explored: Sequence[_Explored]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the corners ``[2]`` of what all maps show."""
    surface = explored[0].arrays["surface"][:, :2].astype(np.float64)
    return surface.min(axis=0) - 0.2, surface.max(axis=0) + 0.2


def _draw(
    axes: Axes, explored: _Explored, name: str, low: npt.NDArray[np.float64], high: npt.NDArray[np.float64]
) -> None:
    record, arrays = explored.record, explored.arrays
    extent = (low[0], high[0], low[1], high[1])
    _draw_building(axes, explored, _FAINT)
    covered = _covered(explored, low, high)
    axes.imshow(covered.T, origin="lower", extent=extent, cmap=_COVERED, vmin=0, vmax=1, interpolation="nearest")
    rejected, chosen = _candidates(record)
    axes.scatter(rejected[:, 0], rejected[:, 1], s=0.4, color="#999999", linewidths=0, rasterized=True)
    left = arrays["frontiers"]
    if len(left):
        axes.scatter(left[:, 0], left[:, 1], s=1.0, color=_FRONTIER, linewidths=0)
    way = arrays["trajectory"]
    axes.scatter(way[:, 0], way[:, 1], s=1.2, c=np.arange(len(way)), cmap="plasma", linewidths=0, rasterized=True)
    axes.scatter(chosen[:, 0], chosen[:, 1], s=7, facecolors="none", edgecolors="black", linewidths=0.5)
    axes.plot(way[0, 0], way[0, 1], "^", color="black", markersize=4)
    _frame(axes, low, high)
    percent = f"{100 * record.final.scr_means:.1f} %"
    axes.set_title(f"{one_line(name)}: {percent}, {record.final.path_length:.0f} m", loc="left")


def _legend() -> list[Line2D | Patch]:
    from matplotlib import colormaps
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    dots = (("candidates", ".", "#999999"), ("frontiers left", ".", _FRONTIER), ("start", "^", "black"))
    shown: list[Line2D | Patch] = [
        Line2D([], [], marker=marker, color=color, linestyle="", label=label) for label, marker, color in dots
    ]
    shown.append(Line2D([], [], marker="o", color="black", markerfacecolor="none", linestyle="", label="chosen"))
    colors = colormaps[_COVERED]
    shown += [Patch(color=colors(1.0), label="covered"), Patch(color=colors(0.0), label="not covered")]
    return shown


def _draw_truth(axes: Axes, explored: _Explored, low: npt.NDArray[np.float64], high: npt.NDArray[np.float64]) -> None:
    """Draw the building from above."""
    record = explored.record
    _draw_building(axes, explored, 1.0)
    _frame(axes, low, high)
    axes.set_title(f"{one_line(record.building)}, seed {record.seed}: truth", loc="left")


def _draw_building(axes: Axes, explored: _Explored, opacity: float) -> None:
    rgb, origin = explored.arrays["above_rgb"], explored.arrays["above_origin"]
    ends = origin + np.array(rgb.shape[:2]) * CELL
    extent = (float(origin[0]), float(ends[0]), float(origin[1]), float(ends[1]))
    axes.imshow(rgb.transpose(1, 0, 2), origin="lower", extent=extent, alpha=opacity, interpolation="nearest")


def _frame(axes: Axes, low: npt.NDArray[np.float64], high: npt.NDArray[np.float64]) -> None:
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.grid(False)
    axes.tick_params(labelsize=6)


def _covered(
    explored: _Explored, low: npt.NDArray[np.float64], high: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return the share ``[nx, ny]`` of each column's surface below the ceiling that is covered; NaN without any."""
    record, arrays = explored.record, explored.arrays
    surface = arrays["surface"].astype(np.float64)
    shown = surface[:, 2] - record.start[2] <= CEILING
    places = surface[shown, :2]
    near = arrays["distance"][shown] < float(record.settings["evaluation"]["threshold"])
    counts = np.ceil((high - low) / _cell(len(places), low, high)).astype(int)
    columns, rows = np.minimum((places - low) // ((high - low) / counts), counts - 1).astype(int).T
    total, reached = np.zeros(counts), np.zeros(counts)
    np.add.at(total, (columns, rows), 1)
    np.add.at(reached, (columns, rows), near)
    return np.where(total > 0, reached / np.maximum(total, 1), np.nan)


def _cell(points: int, low: npt.NDArray[np.float64], high: npt.NDArray[np.float64]) -> float:
    """Return the edge of a column, at least 5 cm, that has two points of the surface in the mean."""
    return max(_COLUMN, float(np.sqrt(2 * np.prod(high - low) / max(points, 1))))


def _candidates(record: ExplorationRecord) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the places ``[n, 2]`` of candidates that were not chosen, and of those that were."""
    rejected, chosen = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for decision in record.decisions:
        places = np.array(decision.candidates)[:, :2]
        taken = decision.paths[decision.chosen].candidate
        rejected.append(np.delete(places, taken, axis=0))
        chosen.append(places[taken : taken + 1])
    return np.concatenate(rejected), np.concatenate(chosen)
