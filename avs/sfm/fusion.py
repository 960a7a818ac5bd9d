"""From depth maps to one cloud of what several views agree on, by COLMAP's fusion, which runs without a GPU."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, FloatArray
from avs.scene.colmap import write_model
from avs.scene.colmap.conversion import as_model
from avs.scene.points import Points
from avs.scene.views import Views
from avs.sfm.cloud import Cloud
from avs.sfm.colmap_workspace import library, row_name, workspace
from avs.sfm.depth_maps import DepthMap, normals_of
from avs.sfm.sfm_settings import FusionSettings
from avs.sfm.source_views import visible

_END = b"end_header\n"
_POINT = np.dtype(
    [
        *((name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz")),
        *((name, "u1") for name in ("red", "green", "blue")),
    ]
)
"""A point of the PLY file that COLMAP writes."""

_GRID, _MANY = 12, 50
"""Points on each side of a picture by which COLMAP is told which views show the same surface. Of more views than that
many there are fewer, as COLMAP's time and memory grow with the pairs of views that see a point."""


def fused(views: Views, maps: dict[int, DepthMap], settings: FusionSettings) -> Cloud:
    """Return the points on which depth maps agree, with the number of views as their confidence.

    Args:
        views: n views.
        maps: depth maps by the row of their view; views without one take no part. They are taken out as they are
            written to disk, since those of many views and COLMAP's need much memory together.
        settings: see there.
    """
    pycolmap = library()

    with workspace(views) as folder:
        points = _write_maps(folder / "stereo", views.cameras, maps, settings.worst_cost)
        names = [row_name(row) for row in range(len(views))]
        write_model(folder / "sparse", as_model(names, views.cameras, _shared_points(views.cameras, points)))
        options = pycolmap.StereoFusionOptions(
            num_threads=1,
            min_num_pixels=settings.views,
            max_depth_error=settings.depth_error,
            max_normal_error=settings.normal_error,
            max_reproj_error=settings.pixel_error,
        )
        pycolmap.stereo_fusion(folder / "fused.ply", folder, options=options, output_type="PLY")
        return _read_fused(folder / "fused.ply")


def _read_fused(path: Path) -> Cloud:
    """Return the cloud that COLMAP wrote, with the numbers of views from the file beside it.

    That file holds the number of points, and for each of them the number of its views and their identifiers.
    """
    content = path.read_bytes()
    body = content.index(_END) + len(_END)
    points = np.frombuffer(content, dtype=_POINT, offset=body)
    numbers = np.fromfile(path.with_name(f"{path.name}.vis"), dtype="<u4")[2:]
    counts, place = np.zeros(len(points), dtype=np.float32), 0
    for row in range(len(points)):
        counts[row] = numbers[place]
        place += 1 + int(numbers[place])
    positions = np.stack([points[axis] for axis in "xyz"], axis=1).astype(np.float64)
    return Cloud(positions, np.stack([points[color] for color in ("red", "green", "blue")], axis=1), counts)


def _write_maps(folder: Path, cameras: Cameras, maps: dict[int, DepthMap], worst_cost: float) -> FloatArray:
    """Write the depth and normal maps as COLMAP reads them, and return some points of them, in world coordinates."""
    for name in ("depth_maps", "normal_maps"):
        (folder / name).mkdir(parents=True)
    grid, points, rows = max(3, round(_GRID * min(1.0, _MANY / len(cameras)))), [np.zeros((0, 3))], sorted(maps)
    for row in rows:
        found = maps.pop(row)
        depth = np.where(found.cost <= worst_cost, found.depth, 0)
        _write_map(folder / "depth_maps" / f"{row_name(row)}.geometric.bin", depth[..., None])
        normals = normals_of(found.planes, cameras[row])
        _write_map(folder / "normal_maps" / f"{row_name(row)}.geometric.bin", normals)
        points.append(_some_points(cameras[row], depth, grid))
    (folder / "fusion.cfg").write_text("".join(f"{row_name(row)}\n" for row in rows))
    return np.concatenate(points)


def _shared_points(cameras: Cameras, places: FloatArray) -> Points:
    """Return points, each observed by every view that could see it: COLMAP compares the views that see the same."""
    _, inside = visible(places, cameras)
    observations = np.argwhere(inside.T).astype(np.int64)
    return Points(places, np.zeros((len(places), 3), dtype=np.uint8), observations)


def _some_points(camera: Cameras, depth: npt.NDArray[np.float32], grid: int) -> FloatArray:
    """Return the positions of ``grid`` x ``grid`` pixels of a depth map, in world coordinates."""
    height, width = depth.shape
    rows, columns = np.meshgrid(
        np.linspace(0, height - 1, grid).astype(np.int64), np.linspace(0, width - 1, grid).astype(np.int64)
    )
    rows, columns = rows[depth[rows, columns] > 0], columns[depth[rows, columns] > 0]
    pixels = np.stack([columns + 0.5, rows + 0.5, np.ones(len(rows))], axis=1)
    local = pixels @ np.linalg.inv(camera.intrinsics[0]).T * depth[rows, columns][:, None]
    transform = camera.world_to_camera[0]
    positions: FloatArray = (local - transform[:3, 3]) @ transform[:3, :3]
    return positions


def _write_map(path: Path, values: npt.NDArray[np.float32]) -> None:
    """Write ``[h, w, c]`` numbers as COLMAP reads them: the size as text, then one picture after another."""
    height, width, channels = values.shape
    content = np.ascontiguousarray(values.transpose(2, 0, 1), dtype="<f4").tobytes()
    path.write_bytes(f"{width}&{height}&{channels}&".encode() + content)
