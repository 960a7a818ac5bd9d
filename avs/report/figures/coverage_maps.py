"""Draws where the views of each method leave the reference of a scene uncovered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from avs.coverage.coverage_record import Coverage
from avs.coverage.episode_coverage import DISTANCE
from avs.report.collect_coverage import coverage_machine_notes
from avs.report.figures.captions import sentences, write_caption
from avs.report.figures.cloud_rendering import coloured, magnified, painted, project
from avs.report.figures.figure_files import STYLE, draw_notice, save_figure
from avs.report.formats.plain_text import one_line
from avs.report.methods import presented
from avs.scene.cameras import Cameras
from avs.scene.scene import read_scene
from avs.sfm.cloud import Cloud
from avs.sfm.cloud_file import read_cloud
from avs.system.errors import UserError
from avs.system.records import read_record

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHARED = ("seed", "settings", "reference")
_REMEDY = "run the job that makes it again"
_LONG_SIDE = 480  # pixels of a map
_WINDOW = 0.3  # edge of the magnified square, in shares of the map's height
_GAP = 8  # pixels between a map and its magnified part
_COLUMNS = 4
_PANEL_WIDTH, _TITLE = 2.1, 0.16  # inches
_NEAREST, _FARTHEST = 1e-3, 1e-1  # ends of the scale of colours, in extents
_TICKS = (1e-3, 1e-2, 1e-1)
_COLOURS = "RdYlBu_r"

_CAPTION = (
    "Coverage of {scene} with seed {seed}: the reference from the camera of the scene that sees most of it, one point "
    "for each voxel, coloured by its distance to the cloud of each method's views, in extents, on a logarithmic scale. "
    "The first map has the colours of the photographs; the squares magnify where the methods together cover least."
)

_Pixels = npt.NDArray[np.uint8]
_Picture = npt.NDArray[np.int64]
_Window = tuple[float, float, float]


@dataclass(frozen=True)
class _Map:
    """One method's coverage: the record, and the distance ``[n]`` of each point of the reference, in extents."""

    record: Coverage
    distances: npt.NDArray[np.float64]


def write_coverage_maps(
    scene_folder: Path, records: Sequence[Path], covered: Sequence[Path], methods: Sequence[str], out: Path
) -> None:
    """Write ``out`` as ``.pdf`` and ``.png``, and its caption as ``.md``: a map for each method, of one scene and seed.

    A map shows the reference, one point for each voxel, from the camera of the scene that sees most of it.
    Colours are the distance of each point to the method's cloud, from blue to red on a logarithmic scale that all maps
    share. The square beside a map magnifies the region of which the methods together cover least. The first map has the
    reference in the colours of the photographs. A scene without a reference cloud has words in place of maps. Equal
    records give equal bytes.

    Args:
        scene_folder: the scene.
        records: ``coverage.json`` of each method that has one, with one seed.
        covered: their ``covered.ply``, in the same order.
        methods: identifiers of the methods, in the order of the maps.
        out: path of the figure without suffix.

    Raises:
        UserError: no record; or one is missing, damaged, of another scene or seed, was measured with other settings,
            or is the second of a method.
    """
    scene = read_scene(scene_folder)
    maps, cloud = _read(records, covered, scene.content_hash)
    first = next(iter(maps.values())).record
    if first.extent is None:
        return draw_notice(f"{first.dataset}, {first.scene}: {first.absent.get('against_reference')}", out)
    voxel = float(first.settings["voxel"]) * first.extent
    projection = project(cloud.positions, _widest(cloud, scene.cameras, voxel), voxel, _LONG_SIDE)
    whole = painted(projection)
    window = _worst(whole, maps)
    pictures = whole, painted(magnified(projection, window, len(whole)))
    _write(cloud, pictures, window, [maps[method] for method in methods if method in maps], out)
    told = _CAPTION.format(scene=f"{first.scene} of {first.dataset}", seed=first.seed)
    write_caption(out, told + sentences(coverage_machine_notes(records)))
    return None


def _write(cloud: Cloud, pictures: tuple[_Picture, _Picture], window: _Window, maps: Sequence[_Map], out: Path) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        rows = -(-(len(maps) + 1) // _COLUMNS)
        height, width = _composed(pictures, cloud.colors).shape[:2]
        size = (_COLUMNS * _PANEL_WIDTH, rows * (_PANEL_WIDTH * height / width + _TITLE) + 0.75)
        figure = Figure(figsize=size, layout="constrained")
        first = maps[0].record
        figure.suptitle(f"{first.dataset}, {first.scene}, seed {first.seed}", x=0.01, ha="left", fontsize=8)
        _draw(figure, rows, cloud, pictures, window, maps)
        save_figure(figure, out)


def _read(records: Sequence[Path], covered: Sequence[Path], scene_hash: str) -> tuple[dict[str, _Map], Cloud]:
    """Return the maps by identifier of the method, and the points that they share."""
    maps: dict[str, _Map] = {}
    cloud: Cloud | None = None
    for path, points in zip(records, covered, strict=True):
        record = read_record(path, Coverage)
        if record.scene_hash != scene_hash:
            raise UserError(path, "is of another version of the scene", _REMEDY)
        first = next(iter(maps.values())).record if maps else record
        if record.method in maps or any(getattr(record, name) != getattr(first, name) for name in _SHARED):
            raise UserError(path, "is a second record of its method, or of another seed or other settings", _REMEDY)
        found, fields = read_cloud(points, _REMEDY)
        cloud = found if cloud is None else cloud
        if DISTANCE not in fields or not np.array_equal(found.positions, cloud.positions):
            raise UserError(points, "does not hold the points of the others, with their distances", _REMEDY)
        maps[record.method] = _Map(record, fields[DISTANCE].astype(np.float64) / (record.extent or 1.0))
    if cloud is None:
        raise UserError("maps of coverage", "no record", "pass at least one coverage.json")
    return maps, cloud


def _widest(cloud: Cloud, cameras: Cameras, voxel: float) -> Cameras:
    """Return the camera, as a batch of one, in whose picture most points are not hidden by others."""
    batches = [cameras[index] for index in range(len(cameras))]
    counts = [len(np.unique(painted(project(cloud.positions, each, voxel, _LONG_SIDE)))) for each in batches]
    return batches[int(np.argmax(counts))]


def _worst(picture: npt.NDArray[np.int64], maps: dict[str, _Map]) -> _Window:
    """Return the square in which the methods together leave most uncovered: left, top and edge in pixels."""
    threshold = float(next(iter(maps.values())).record.settings["threshold"])
    uncovered = np.mean([each.distances >= threshold for each in maps.values()], axis=0)
    shown = np.append(uncovered, 0.0)[picture]
    edge = round(_WINDOW * picture.shape[0])
    sums = np.pad(shown, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    boxes = sums[edge:, edge:] - sums[:-edge, edge:] - sums[edge:, :-edge] + sums[:-edge, :-edge]
    top, left = np.unravel_index(int(np.argmax(boxes)), boxes.shape)
    return float(left), float(top), float(edge)


def _composed(pictures: tuple[_Picture, _Picture], colors: _Pixels) -> _Pixels:
    """Return a map and, beside it, its magnified part, in these colours of points."""
    whole, part = (coloured(picture, colors) for picture in pictures)
    gap = np.full((len(whole), _GAP, 3), 255, dtype=np.uint8)
    return np.concatenate([whole, gap, part], axis=1)


def _draw(
    figure: Figure,
    rows: int,
    cloud: Cloud,
    pictures: tuple[_Picture, _Picture],
    window: _Window,
    maps: Sequence[_Map],
) -> None:
    import matplotlib as mpl
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm
    from matplotlib.patches import Rectangle

    scale = ScalarMappable(LogNorm(_NEAREST, _FARTHEST, clip=True), mpl.colormaps[_COLOURS])
    axes = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
    titles = ["reference", *(_title(each.record) for each in maps)]
    finite = [np.minimum(np.maximum(each.distances, _NEAREST), _FARTHEST) for each in maps]
    colors = [cloud.colors, *(scale.to_rgba(each, bytes=True)[:, :3] for each in finite)]
    for panel, title, own in zip(axes, titles, colors, strict=False):
        panel.imshow(_composed(pictures, own), interpolation="nearest")
        frame: dict[str, Any] = {"fill": False, "edgecolor": "black", "linewidth": 0.6}
        panel.add_patch(Rectangle(window[:2], window[2], window[2], **frame))
        panel.set_title(title, fontsize=6.5, loc="left", pad=2)
    for panel in axes:
        panel.set_axis_off()
    bar = figure.colorbar(scale, ax=list(axes), location="bottom", fraction=0.03, aspect=60, pad=0.02)
    bar.set_label("distance of the reference to the method's cloud, in extents", fontsize=7)
    bar.set_ticks(_TICKS, labels=[f"{tick:g}" for tick in _TICKS])
    bar.ax.tick_params(labelsize=6.5)


def _title(record: Coverage) -> str:
    label = one_line(presented(record.method).label)
    return f"{label}: SCR {100.0 * record.against_reference.scr:.1f} %" if record.against_reference else label
