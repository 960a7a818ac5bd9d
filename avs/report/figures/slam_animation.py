"""An exploration as an animation: what the camera sees, what the final map renders there, and the way from above."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from PIL import Image
from torch.nn import Parameter

from avs.report.collect_explorations import read_maps
from avs.slam.building.opened_building import open_simulator
from avs.slam.building.robot_camera import CameraSettings, Pose, camera_at
from avs.slam.building.side_files import mesh_digest
from avs.slam.building.simulator import Simulator
from avs.slam.evaluation.top_view import CELL
from avs.slam.loop.exploration_record import ExplorationRecord
from avs.slam.loop.slam_settings import SlamSettings
from avs.slam.mapping.gaussian_map import NAMES, MapTensors, map_seen
from avs.system.errors import UserError
from avs.system.files import atomic_path
from avs.system.records import read_record

Picture = npt.NDArray[np.uint8]
Place = Callable[[Pose], tuple[int, int]]

_MOST_FRAMES = 60
_MILLISECONDS = 120
_WIDTH = 240
_GAP = 4
_WAY, _ROBOT = (230, 120, 0), (200, 0, 120)


def write_slam_animation(record: Path, maps: Path, mesh: Path, out: Path) -> None:
    """Write a GIF of an exploration, of at most sixty frames.

    Side by side: the camera's picture, the rendering of the map as it was at the end, and the building from above with
    the way so far. Equal records give equal bytes.

    Args:
        record: ``exploration.json``.
        maps: its ``maps.safetensors``.
        mesh: the building's file.
        out: the GIF.

    Raises:
        UserError: a file is missing or damaged, or the mesh is another one than was explored.
    """
    told = read_record(record, ExplorationRecord)
    if mesh_digest(mesh) != told.building_hash:
        raise UserError(mesh, f"is not the building that {record} explored", "run the exploration again")
    settings = SlamSettings.model_validate(told.settings)
    arrays = read_maps(maps)
    tensors: MapTensors = {name: Parameter(torch.from_numpy(arrays[name].copy())) for name in NAMES}
    simulator = open_simulator(mesh, settings.simulator)
    poses = [Pose(*row) for row in arrays["trajectory"].tolist()]
    camera = settings.camera.model_copy(update=_size(settings.camera))
    above, place = _from_above(arrays, camera.height)
    step = -(-len(poses) // _MOST_FRAMES)
    pictures = []
    for index in range(0, len(poses), step):
        _mark(above, [place(pose) for pose in poses[max(index - step, 0) : index + 1]], _WAY, 1)
        shown = above.copy()
        _mark(shown, [place(poses[index])], _ROBOT, 3)
        pictures.append(_beside(_views(simulator, tensors, poses[index], camera), shown))
    images = [Image.fromarray(picture).quantize(128) for picture in pictures]
    with atomic_path(out) as temporary:
        options = {"save_all": True, "append_images": images[1:], "duration": _MILLISECONDS, "loop": 0}
        images[0].save(temporary, format="GIF", **options)


def _size(camera: CameraSettings) -> dict[str, int]:
    return {"width": _WIDTH, "height": round(_WIDTH * camera.height / camera.width)}


def _views(simulator: Simulator, tensors: MapTensors, pose: Pose, camera: CameraSettings) -> list[Picture]:
    """Return what the camera sees, and what the map renders."""
    at = camera_at(pose, camera)
    rendered = map_seen(tensors, at).rgb.clamp(0, 1).numpy()
    return [simulator.observe(at).rgb, np.rint(rendered * 255).astype(np.uint8)]


def _from_above(arrays: dict[str, npt.NDArray[Any]], height: int) -> tuple[Picture, Place]:
    """Return the building from above, ``height`` pixels high, and the function that gives the pixel of a pose."""
    rgb, origin = arrays["above_rgb"].transpose(1, 0, 2)[::-1], arrays["above_origin"]
    scale = height / (rgb.shape[0] * CELL)
    size = (round(rgb.shape[1] * CELL * scale), height)
    picture = np.array(Image.fromarray(np.ascontiguousarray(rgb)).resize(size, Image.Resampling.BOX))

    def pixel(pose: Pose) -> tuple[int, int]:
        row, column = height - 1 - int((pose.y - origin[1]) * scale), int((pose.x - origin[0]) * scale)
        return min(max(row, 0), size[1] - 1), min(max(column, 0), size[0] - 1)

    return picture, pixel


def _mark(picture: Picture, places: list[tuple[int, int]], color: tuple[int, ...], reach: int) -> None:
    for row, column in places:
        picture[max(row - reach, 0) : row + reach + 1, max(column - reach, 0) : column + reach + 1] = color


def _beside(views: list[Picture], above: Picture) -> Picture:
    gap = np.full((above.shape[0], _GAP, 3), 255, np.uint8)
    return np.concatenate([views[0], gap, views[1], gap, above], axis=1)
