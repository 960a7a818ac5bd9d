"""An episode in a browser while a program runs: its model, and its cameras in the order of selection.

viser, an optional package, serves it on this machine alone.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from avs.nvs.record import Episode
from avs.report.figures.overview import outline_depth, overview_of
from avs.report.page.exported_model import SPLATS, read_exported_model
from avs.scene.cameras import Cameras
from avs.scene.scene import Scene, read_scene
from avs.system.errors import UserError
from avs.system.records import read_record

HOST = "127.0.0.1"
"""Nobody else on the network can look."""

Color = tuple[int, int, int]

_ROLES: dict[str, Color] = {
    "initial": (32, 38, 44),
    "selected": (11, 92, 173),
    "chosen": (213, 72, 11),
    "test": (181, 139, 214),
}
_LOW, _HIGH = np.array([49.0, 84.0, 165.0]), np.array([244.0, 200.0, 60.0])


def serve_episode(record: Path, scene_folder: Path, port: int) -> Any:  # noqa: ANN401 (a package that may be absent)
    """Start to serve an episode at ``http://127.0.0.1:<port>`` and return the server.

    Args:
        record: ``episode.json``, with its model beside it.
        scene_folder: the scene of the episode.
        port: of this machine.

    Raises:
        UserError: viser is not installed; or a file is missing, damaged, or of another scene.
    """
    try:
        viser = importlib.import_module("viser")
    except ImportError as error:
        remedy = "pip install --no-deps --requirement environment-optional.txt"
        raise UserError("viser", "is not installed", remedy) from error
    episode, scene = read_record(record, Episode), read_scene(scene_folder)
    if episode.scene_hash != scene.content_hash:
        raise UserError(scene_folder, "is not the scene of the episode", "name its scene with --scene")
    server = viser.ViserServer(host=HOST, port=port, verbose=False)
    server.scene.set_up_direction(tuple(overview_of(scene.cameras[scene.pool]).up))
    _add_model(server, record.with_name(SPLATS), scene)
    _add_steps(server, episode, scene)
    return server


def _add_model(server: Any, path: Path, scene: Scene) -> None:  # noqa: ANN401
    """Show the Gaussians, or the scene's points where the episode has exported none."""
    if not path.exists():
        server.scene.add_point_cloud("/points", scene.points.positions, scene.points.colors, point_size=0.01)
        return
    model = read_exported_model(path, scene.to_capture)
    server.scene.add_gaussian_splats(
        "/model",
        centers=model.means.astype(np.float32),
        covariances=covariances(model.quats, model.scales).astype(np.float32),
        rgbs=model.colors.astype(np.float32),
        opacities=model.opacities[:, None].astype(np.float32),
    )


def _add_steps(server: Any, episode: Episode, scene: Scene) -> None:  # noqa: ANN401
    """Show the cameras at the selection that a slider names."""
    last = len(episode.steps)
    slider = server.gui.add_slider("selection", min=1, max=last + 1, step=1, initial_value=last + 1)
    depth = outline_depth(scene.cameras[scene.pool], overview_of(scene.cameras[scene.pool]))

    def draw(_: object = None) -> None:
        server.scene.remove_by_name("/cameras")
        for name, color in camera_colors(episode, scene, int(slider.value) - 1).items():
            # by number beside the name: in folders of one capture names can agree, and one node replaces another
            row = scene.names.index(name)
            _add_camera(server, f"/cameras/{row}_{Path(name).stem}", scene.cameras[row], color, depth)

    slider.on_update(draw)
    draw()


def camera_colors(episode: Episode, scene: Scene, step: int) -> dict[str, Color]:
    """Return the colour of each camera by image name at a selection, from 0; after the last one, at the end.

    Candidates have their scores, from blue for the lowest to yellow for the highest; without scores they are left out.
    """
    colors = dict.fromkeys((scene.names[row] for row in scene.test), _ROLES["test"])
    if step < len(episode.steps) and episode.steps[step].scores is not None:
        pairs = zip(episode.steps[step].candidates, episode.steps[step].scores or [], strict=True)
        scores = {name: score for name, score in pairs if score is not None}
        low, high = min(scores.values()), max(scores.values())
        for name, score in scores.items():
            share = (score - low) / (high - low) if high > low else 0.5
            red, green, blue = np.rint(_LOW + share * (_HIGH - _LOW)).astype(int).tolist()
            colors[name] = (red, green, blue)
    colors |= dict.fromkeys(episode.initial, _ROLES["initial"])
    for place, each in enumerate(episode.steps[: step + 1]):
        colors |= dict.fromkeys(each.chosen, _ROLES["chosen" if place == step else "selected"])
    return colors


def _add_camera(server: Any, name: str, camera: Cameras, color: Color, depth: float) -> None:  # noqa: ANN401
    width, height = camera.sizes[0]
    rotation = camera.world_to_camera[0, :3, :3].T
    server.scene.add_camera_frustum(
        name,
        fov=float(2 * np.arctan(height / 2 / camera.intrinsics[0, 1, 1])),
        aspect=float(width / height),
        scale=depth,
        color=color,
        wxyz=quaternion(rotation),
        position=camera.centers[0],
    )


def covariances(quats: npt.NDArray[np.float64], scales: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the covariance ``[n, 3, 3]`` of Gaussians.

    Args:
        quats: ``[n, 4]`` rotations as (w, x, y, z), of any length but zero.
        scales: ``[n, 3]`` standard deviations along the rotated axes.
    """
    from scipy.spatial.transform import Rotation

    halves = Rotation.from_quat(quats[:, [1, 2, 3, 0]]).as_matrix() * scales[:, None, :]
    product: npt.NDArray[np.float64] = halves @ halves.transpose(0, 2, 1)
    return product


def quaternion(rotation: npt.NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Return a rotation matrix ``[3, 3]`` as the quaternion (w, x, y, z)."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat().tolist()
    return (w, x, y, z)
