"""Points of the truly visible surface of a scene whose geometry is known."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import PurePosixPath

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import FloatArray, IndexArray
from avs.scene.scene import Scene
from avs.scene.scene_file import REMEDY, read_scene_file
from avs.system.errors import UserError
from avs.system.files import file_hash


@dataclass(frozen=True)
class Surface:
    """Points of a surface as views show it.

    Attributes:
        points: ``[m, 3]`` scene coordinates.
        resolution: ``[m]`` pixels that one scene unit takes at the point in the view that shows it.
    """

    points: FloatArray
    resolution: FloatArray


def visible_surface(scene: Scene, rows: IndexArray) -> Surface | None:
    """Return where the rays through the centres of all pixels of some views meet the true surface.

    They are what the views show, as a cloud without any error would hold it.

    Args:
        scene: with ``depth/`` if its geometry is known.
        rows: indices of the views that see.

    Returns:
        The points, in the order of views and pixels; None for a scene without known geometry.

    Raises:
        UserError: a depth map is not the one that was prepared, or cannot be read.
    """
    listed = read_scene_file(scene.folder).files
    paths = [str(PurePosixPath("depth") / PurePosixPath(scene.names[row]).with_suffix(".npy")) for row in rows]
    if any(path not in listed for path in paths):
        return None
    found = [_points(scene, row, _depth(scene, path, listed[path])) for row, path in zip(rows, paths, strict=True)]
    return Surface(np.concatenate([each.points for each in found]), np.concatenate([each.resolution for each in found]))


def _depth(scene: Scene, name: str, listed: str) -> npt.NDArray[np.float32]:
    path = scene.folder / name
    if not path.is_file():
        raise UserError(path, "is missing", REMEDY)
    if file_hash(path) != listed:
        raise UserError(path, "is not the file that scene.json lists", REMEDY)
    depth: npt.NDArray[np.float32] = np.load(path, allow_pickle=False)
    return depth


def _points(scene: Scene, row: int, depth: npt.NDArray[np.float32]) -> Surface:
    """Return the points of a depth map along the optical axis, where it is greater than 0."""
    pose, matrix = scene.cameras.world_to_camera[row], scene.cameras.intrinsics[row]
    y, x = np.nonzero(depth > 0)
    rays = np.stack([x + 0.5, y + 0.5, np.ones(len(x))], axis=1) @ np.linalg.inv(matrix).T
    along = depth[y, x].astype(np.float64)
    return Surface((rays * along[:, None] - pose[:3, 3]) @ pose[:3, :3], matrix[0, 0] / along)
